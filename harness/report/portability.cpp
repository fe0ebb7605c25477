#include "harness/report/portability.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench::report {

namespace {

using State = PlatformTime::State;

std::string problem_of(const BenchRow& row) {
  return fmt::format("{}, {} x {}, {}", row.scene, row.width, row.height, row.method);
}

template <typename List, typename Name, typename Member>
auto& found_or_added(List& list, const Name& name, Member member) {
  const auto found = std::ranges::find(list, name, member);
  if (found != list.end()) {
    return *found;
  }
  auto& added = list.emplace_back();
  added.*member = name;
  return added;
}

std::size_t index_or_added(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) {
    names.push_back(name);
    return names.size() - 1;
  }
  return static_cast<std::size_t>(found - names.begin());
}

/// The faster one stays: other threads, another device of the same processor. One that is wrong stays wrong.
void take(PlatformTime& time, const BenchRow& row, bool disagrees) {
  if (!row.counts() || disagrees) {
    time = {.state = State::wrong};
  } else if (row.seconds_median && time.state != State::wrong &&
             (!time.seconds || *row.seconds_median < *time.seconds)) {
    time = {.state = State::ran,
            .seconds = row.seconds_median,
            .msites_per_second = row.msites_per_second,
            .architectural_efficiency =
                row.percent_of_ceiling ? std::optional(*row.percent_of_ceiling / 100.0) : std::nullopt};
  }
}

void rate(PortableProblem& problem) {
  for (std::size_t platform = 0; platform < problem.platforms.size(); ++platform) {
    std::optional<double> best;
    for (const ApplicationPortability& one : problem.applications) {
      const std::optional<double>& seconds = one.times[platform].seconds;
      best = seconds && (!best || *seconds < *best) ? seconds : best;
    }
    for (ApplicationPortability& one : problem.applications) {
      PlatformTime& time = one.times[platform];
      if (time.seconds) {
        time.application_efficiency = *time.seconds > 0.0 ? *best / *time.seconds : 1.0;
      }
    }
  }
  for (ApplicationPortability& one : problem.applications) {
    std::vector<double> of_applications;
    std::vector<double> of_architecture;
    bool has_ceilings = true;
    for (const PlatformTime& time : one.times) {
      of_applications.push_back(time.application_efficiency.value_or(0.0));
      of_architecture.push_back(time.architectural_efficiency.value_or(0.0));
      has_ceilings = has_ceilings && (time.state != State::ran || time.architectural_efficiency);
    }
    one.of_applications = performance_portability(of_applications);
    if (has_ceilings) {
      one.of_architecture = performance_portability(of_architecture);
    }
  }
}

std::string csv_word(const std::string& word) {
  std::string quoted = "\"";
  for (const char c : word) {
    quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  }
  return quoted + "\"";
}

} // namespace

std::string platform_of(const Results& results, std::size_t source, const std::string& backend,
                        const std::string& device) {
  const Source& from = results.sources[source];
  if (device.empty() || device == from.cpu || results.is_software(from.machine, backend, device)) {
    return from.machine;
  }
  return fmt::format("{} ({})", device, from.machine);
}

std::vector<PlatformTier> tiers_by_platform(const Results& results) {
  std::vector<PlatformTier> tiers;
  for (const VerifyRow& row : results.verify) {
    if (row.verdict == Verdict::skipped) {
      continue;
    }
    const std::string platform = platform_of(results, row.source, row.backend, row.device.name);
    auto found = std::ranges::find_if(tiers, [&](const PlatformTier& tier) {
      return tier.application == row.backend && tier.platform == platform;
    });
    if (found == tiers.end()) {
      found = tiers.insert(tiers.end(), {.application = row.backend, .platform = platform, .tier = row.tier});
    }
    found->tier = std::min(found->tier, row.tier);
    found->disagrees = found->disagrees || row.verdict == Verdict::disagree;
    ++found->comparisons;
  }
  return tiers;
}

std::vector<PortableProblem> portability(const Results& results) {
  const std::vector<PlatformTier> tiers = tiers_by_platform(results);
  std::vector<PortableProblem> problems;
  for (const BenchRow& row : results.bench) {
    const bool ran = row.seconds_median && row.counts();
    if (!ran && row.device.empty()) {
      continue; // nothing there to be wrong
    }
    PortableProblem& problem = found_or_added(problems, problem_of(row), &PortableProblem::name);
    const std::string platform = platform_of(results, row.source, row.backend, row.device);
    const std::size_t index = index_or_added(problem.platforms, platform);
    auto& application =
        found_or_added(problem.applications, row.backend, &ApplicationPortability::application);
    for (ApplicationPortability& one : problem.applications) {
      one.times.resize(problem.platforms.size());
    }
    const bool disagrees = std::ranges::any_of(tiers, [&](const PlatformTier& tier) {
      return tier.disagrees && tier.application == row.backend && tier.platform == platform;
    });
    take(application.times[index], row, disagrees);
  }
  std::ranges::for_each(problems, rate);
  return problems;
}

double performance_portability(std::span<const double> efficiencies) {
  double sum = 0.0;
  for (const double efficiency : efficiencies) {
    if (!(efficiency > 0.0)) {
      return 0.0;
    }
    sum += 1.0 / efficiency;
  }
  return efficiencies.empty() ? 0.0 : static_cast<double>(efficiencies.size()) / sum;
}

std::string p3_csv(const std::vector<PortableProblem>& problems) {
  std::string text = "problem,platform,application,fom\n";
  for (const PortableProblem& problem : problems) {
    for (const ApplicationPortability& application : problem.applications) {
      for (std::size_t i = 0; i < problem.platforms.size(); ++i) {
        const std::optional<double>& seconds = application.times[i].seconds;
        text +=
            fmt::format("{},{},{},{}\n", csv_word(problem.name), csv_word(problem.platforms[i]),
                        csv_word(application.application), seconds ? fmt::format("{:.9g}", *seconds) : "");
      }
    }
  }
  return text;
}

} // namespace hdmbench::report
