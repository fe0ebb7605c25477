#include "harness/report/verdict.hpp"

#include "harness/report/grouped.hpp"
#include "harness/scene/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <iterator>
#include <map>
#include <set>

namespace hdmbench::report {

namespace {

using nlohmann::json;
using Names = std::set<std::string>;

using Findings = std::vector<Finding>;

std::int64_t count_if(const Rows& rows, const std::function<bool(const json&)>& belongs) {
  return std::ranges::count_if(rows, [&](const json* row) { return belongs(*row); });
}

std::string plural(std::int64_t count, std::string_view noun) {
  return fmt::format("{} {}{}", grouped(count), noun, count == 1 ? "" : "s");
}

/// The first few names, and how many more there are.
std::string few(const Names& names) {
  constexpr std::ptrdiff_t most = 6;
  const auto end = std::next(names.begin(), std::min(most, std::ssize(names)));
  return joined(Names(names.begin(), end), "; ") +
         (std::ssize(names) > most ? fmt::format("; and {} more", std::ssize(names) - most) : "");
}

/// A finding about the rows that `belongs` picks, each named by `name`, where there are any. `sentence`
/// begins after their number: "timings belong to a field that is not scalar's".
void find(Findings& findings, State state, const Rows& rows, const std::function<bool(const json&)>& belongs,
          const std::function<std::string(const json&)>& name, std::string_view sentence) {
  Names names;
  std::int64_t count = 0;
  for (const json* const row : rows) {
    if (belongs(*row)) {
      ++count;
      names.insert(name(*row));
    }
  }
  if (count > 0) {
    findings.push_back({state, fmt::format("{} of {} {}: {}.", grouped(count), grouped(std::ssize(rows)),
                                           sentence, few(names))});
  }
}

std::string on_scene(const json& row) {
  const std::string backend = text_of(row, "backend");
  return (backend.empty() ? text_of(row, "method") : backend) + " on " + text_of(row, "scene");
}

std::string method_on_scene(const json& row) {
  return (text_of(row, "backend").empty() ? "" : text_of(row, "method") + " by ") + on_scene(row) + ", " +
         size_of(row);
}

bool is_positive(const json& row, std::string_view key) {
  return number_of(row, key).value_or(0.0) > 0.0;
}

/// Backends on scenes where nothing at all was compared; that one mode or method of several does not apply is
/// no concern.
void find_skipped(Findings& findings, const Rows& rows, std::string_view what) {
  Names compared;
  for (const json* const row : rows) {
    if (was_compared(*row)) {
      compared.insert(on_scene(*row));
    }
  }
  std::map<std::string, Names> by_reason;
  std::int64_t not_applying = 0;
  for (const json* const row : rows) {
    if (!was_compared(*row) && compared.contains(on_scene(*row))) {
      ++not_applying;
    } else if (!was_compared(*row)) {
      const std::string reason = text_of(*row, "reason");
      by_reason[reason.empty() ? "no reason is given" : reason].insert(on_scene(*row));
    }
  }
  for (const auto& [reason, places] : by_reason) {
    findings.push_back(
        {State::unsure, fmt::format("Skipped, so not checked: {} ({}).", few(places), reason)});
  }
  if (not_applying > 0) {
    findings.push_back(
        {State::good, fmt::format("{} {} not apply to the backend or the scene.", plural(not_applying, what),
                                  not_applying == 1 ? "does" : "do")});
  }
}

void find_in_verify(Findings& findings, const Results& results, std::string_view machine) {
  const Rows rows = rows_of(results, "verify", machine);
  Rows compared;
  Names backends;
  for (const json* const row : rows) {
    if (was_compared(*row)) {
      compared.push_back(row);
      backends.insert(text_of(*row, "backend"));
    }
  }
  const auto is_certified = [](const json& row) { return text_of(row, "verdict") == "certified"; };
  const auto is_mistrusted = [](const json& row) { return text_of(row, "verdict") == "mistrusted"; };
  find(findings, State::bad, compared, disagrees, on_scene, "comparisons disagree with scalar");
  find(findings, State::unsure, compared, is_mistrusted, on_scene, "comparisons cannot be trusted");
  const std::int64_t certified = count_if(compared, is_certified);
  const std::int64_t agree = std::ssize(compared) - count_if(compared, [&](const json& row) {
                               return disagrees(row) || is_mistrusted(row);
                             });
  if (rows.empty()) {
    findings.push_back(
        {State::unsure, "Nothing was compared with scalar: there are no results of hdmbench verify."});
  } else if (compared.empty()) {
    findings.push_back({State::unsure, "Nothing was compared with scalar: all comparisons were skipped."});
  } else if (agree == std::ssize(compared)) {
    findings.push_back(
        {State::good,
         fmt::format("{} {} with scalar in {} of {}, {}.",
                     backends.size() == 1 ? *backends.begin()
                                          : fmt::format("All {} backends", backends.size()),
                     backends.size() == 1 ? "agrees" : "agree", grouped(agree),
                     plural(std::ssize(compared), "comparison"),
                     certified == 0 ? "to the last bit"
                                    : fmt::format("in {} of them with each difference certified as rounding",
                                                  grouped(certified)))});
  } else if (agree > 0) {
    findings.push_back({State::good, fmt::format("{} of {} agree with scalar.", grouped(agree),
                                                 plural(std::ssize(compared), "comparison"))});
  }
  find_skipped(findings, rows, "comparison");
  for (const json* const device : rows_of(results, "devices", machine)) {
    const std::string backend = text_of(*device, "backend");
    const bool named =
        std::ranges::any_of(rows, [&](const json* row) { return text_of(*row, "backend") == backend; });
    if (!named && backend != "scalar") {
      const std::string reason = text_of(*device, "reason");
      findings.push_back({State::unsure, fmt::format("{} was not compared{}.", backend,
                                                     reason.empty() ? "" : ": " + reason)});
    }
  }
}

void find_in_golden(Findings& findings, const Rows& rows) {
  const auto is = [](const char* verdict) {
    return [verdict](const json& row) { return text_of(row, "verdict") == verdict; };
  };
  const auto differs = [](const json& row) {
    return text_of(row, "verdict") == "disagree" ||
           (text_of(row, "verdict") == "agree" && number_of(row, "first_difference"));
  };
  find(findings, State::bad, rows, differs, on_scene, "solutions have not the golden hashes");
  find(findings, State::unsure, rows, is("mistrusted"), on_scene,
       "solutions have scalar's bits, but there are no golden hashes to compare with");
  const std::int64_t agree = count_if(rows, is("agree"));
  if (agree > 0) {
    findings.push_back({State::good, fmt::format("{} {} the hashes that are committed with the program.",
                                                 plural(agree, "solution"), agree == 1 ? "has" : "have")});
  }
  find_skipped(findings, rows, "golden solution");
}

void find_in_checks(Findings& findings, const Results& results, std::string_view machine) {
  const Rows drivers = rows_of(results, "implementations", machine);
  const auto outcome_is = [](const char* outcome) {
    return [outcome](const json& row) { return text_of(row, "outcome") == outcome; };
  };
  const auto on_driver = [](const json& row) {
    return fmt::format("{} on {} ({})", text_of(row, "backend"), text_of(row, "implementation"),
                       text_of(row, "outcome"));
  };
  find(findings, State::bad, drivers, outcome_is("failed"), on_driver, "backends on other drivers disagree");
  find(
      findings, State::unsure, drivers,
      [&](const json& row) {
        return !outcome_is("failed")(row) && !outcome_is("passed")(row) && !outcome_is("absent")(row);
      },
      on_driver, "backends on other drivers gave no answer");
  if (const std::int64_t passed = count_if(drivers, outcome_is("passed")); passed > 0) {
    findings.push_back(
        {State::good, fmt::format("{} on other drivers agree with scalar, too.", plural(passed, "backend"))});
  }

  const Rows faults = rows_of(results, "faults", machine);
  const auto fault_name = [](const json& row) {
    return text_of(row, "fault") + " on " + text_of(row, "backend");
  };
  const auto ran = [](const json& row) {
    return row.contains("scenes") && std::ranges::any_of(row["scenes"], [](const json& scene) {
             static const Names verdicts{"agree", "certified", "disagree"};
             return verdicts.contains(text_of(scene, "verdict"));
           });
  };
  const auto is_missed = [&](const json& row) { // also where a row contradicts itself
    const bool unseen = text_of(row, "expected") == "disagree" && ran(row) && flag_of(row, "caught") == false;
    return unseen || !flag_of(row, "as_expected").value_or(false);
  };
  find(findings, State::bad, faults, is_missed, fault_name,
       "planted faults and controls came out otherwise than expected");
  find(
      findings, State::unsure, faults, [&](const json& row) { return !is_missed(row) && !ran(row); },
      fault_name, "planted faults were not run");
  if (const auto good = count_if(faults, [&](const json& row) { return !is_missed(row) && ran(row); });
      good > 0) {
    findings.push_back(
        {State::good, fmt::format("{} and controls came out as expected.", plural(good, "planted fault"))});
  }

  const Rows calls = rows_of(results, "failing-calls", machine);
  std::int64_t failed = 0;
  for (const json* const row : calls) {
    failed += static_cast<std::int64_t>(number_of(*row, "failed").value_or(0.0));
  }
  const auto is_unclean = [](const json& row) { return row.contains("unclean") && !row["unclean"].empty(); };
  find(
      findings, State::bad, calls, is_unclean,
      [](const json& row) { return text_of(row, "kind") + " on " + text_of(row, "backend"); },
      "kinds of failing calls of drivers end unclean");
  if (failed > 0 && count_if(calls, is_unclean) == 0) {
    findings.push_back(
        {State::good, fmt::format("{} of drivers ended clean.", plural(failed, "failing call"))});
  }
}

void find_in_accuracy(Findings& findings, const Results& results, std::string_view machine) {
  const auto is_ours = [](const json& row) { return !text_of(row, "backend").empty(); };
  const auto is_ok = [](const json& row) { return text_of(row, "status") == "ok"; };
  const auto is_skipped = [](const json& row) { return text_of(row, "status").starts_with("skipped"); };
  const auto is_valid = [](const json& row) { return flag_of(row, "valid").value_or(false); };
  for (const char* const command : {"accuracy", "tradeoff"}) {
    Rows rows = rows_of(results, command, machine);
    std::erase_if(rows, [](const json* row) { return text_of(*row, "kind") == "equal accuracy"; });
    find(
        findings, State::bad, rows,
        [&](const json& row) { return is_ours(row) && is_ok(row) && !is_valid(row); }, method_on_scene,
        "fields are not finite, or not scalar's");
    find(
        findings, State::bad, rows,
        [](const json& row) { return is_positive(row, "arithmetic.resynchronised.beyond_bound"); }, on_scene,
        "runs in float32 leave the derived bound");
    find(
        findings, State::unsure, rows,
        [&](const json& row) { return is_ours(row) && !is_ok(row) && !is_skipped(row); }, method_on_scene,
        "fields could not be judged");
    find(
        findings, State::good, rows, [&](const json& row) { return !is_ours(row) && !is_ok(row); },
        method_on_scene, "points have no result, of other solvers");
    const auto misses = [](const json& row) {
      const auto asked = number_of(row, "asked");
      return asked && asked_error(row).value_or(0.0) > *asked;
    };
    const auto says_so = [](const json& row) {
      return number_of(row, "estimated_error").value_or(0.0) > number_of(row, "asked").value_or(0.0);
    };
    const auto request = [](const json& row) {
      return fmt::format("{} px asked, {:.3g} px reached by {}", number_of(row, "asked").value_or(0.0),
                         asked_error(row).value_or(0.0), method_on_scene(row));
    };
    find(
        findings, State::bad, rows, [&](const json& row) { return misses(row) && !says_so(row); }, request,
        "points miss the accuracy that was asked for and estimated");
    find(
        findings, State::unsure, rows, [&](const json& row) { return misses(row) && says_so(row); }, request,
        "points miss the accuracy that was asked for, and say so");
  }
  const Rows runs = rows_of(results, "run", machine);
  find(
      findings, State::unsure, runs, [](const json& row) { return !flag_of(row, "plan.met").value_or(true); },
      method_on_scene, "runs do not reach what was asked for");
  const Rows timings = rows_of(results, "bench", machine);
  find(
      findings, State::bad, timings,
      [](const json& row) { return flag_of(row, "valid") == false && number_of(row, "seconds_median"); },
      method_on_scene, "timings belong to a field that is not scalar's");
  find(
      findings, State::unsure, timings,
      [](const json& row) { return flag_of(row, "valid") == false && !number_of(row, "seconds_median"); },
      method_on_scene, "timings have no result");
  const auto unchecked = count_if(
      timings, [](const json& row) { return number_of(row, "seconds_median") && !flag_of(row, "valid"); });
  if (unchecked > 0) {
    findings.push_back(
        {State::good, fmt::format("{} {} not checked against scalar, so no speed-up is printed.",
                                  plural(unchecked, "timing"), unchecked == 1 ? "was" : "were")});
  }
}

} // namespace

std::string_view name_of(State state) {
  static constexpr std::array<std::string_view, 3> names{"good", "unsure", "bad"};
  return names.at(static_cast<std::size_t>(state));
}

Verdict verdict_of(const Results& results, std::string_view machine) {
  Findings findings;
  find_in_verify(findings, results, machine);
  find_in_golden(findings, rows_of(results, "golden", machine));
  find_in_checks(findings, results, machine);
  find_in_accuracy(findings, results, machine);
  if (std::ranges::any_of(results, [&](const Source& source) {
        return source.context.quick && (machine.empty() || source.context.machine == machine);
      })) {
    findings.push_back(
        {State::good, "Some of it was measured with --quick, which does less than a full run."});
  }
  std::ranges::stable_sort(findings, std::ranges::greater(), &Finding::state);
  Verdict verdict{
      .state = findings.front().state, .sentence = findings.front().sentence, .notes = {}, .figures = {}};
  verdict.notes.assign(findings.begin() + 1, findings.end());
  verdict.figures = figures_of(results, machine);
  return verdict;
}

} // namespace hdmbench::report
