#include "harness/agreement/verify.hpp"
#include "harness/agreement/tiers.hpp"

#include "harness/commands/arguments.hpp"
#include "harness/commands/commands.hpp"
#include "harness/context.hpp"
#include "harness/file_output.hpp"
#include "harness/methods/method.hpp"
#include "harness/solve.hpp"
#include "harness/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace hdmbench::commands {

namespace {

/// Iterations per level of a --quick run.
constexpr int quick_iterations = 10;

nlohmann::json to_json(const FirstDifference& first) {
  return {{"level", first.level},
          {"iteration", first.iteration},
          {"x", first.x},
          {"y", first.y},
          {"expected", first.expected},
          {"found", first.found},
          {"energy_before", first.energy_before},
          {"energy_expected", first.energy_expected},
          {"energy_found", first.energy_found},
          {"certified", first.certificate.holds},
          {"gap_over_bound", first.certificate.gap_over_bound}};
}

nlohmann::json to_json(const Scene& scene, const Comparison& comparison) {
  return {{"scene", scene.name},
          {"width", scene.extent().width},
          {"height", scene.extent().height},
          {"backend", comparison.backend},
          {"device", comparison.device.name},
          {"mode", name_of(comparison.mode)},
          {"levels", comparison.levels},
          {"method", method_name(scene.schedule)},
          {"iterations", comparison.iterations},
          {"sweeps", comparison.sweeps},
          {"sites_compared", comparison.sites_compared},
          {"sites_differing", comparison.sites_differing},
          {"sites_drifted", comparison.sites_drifted},
          {"not_finite", comparison.not_finite},
          {"counts_differing", comparison.counts_differing},
          {"certified_ties", comparison.certified_ties},
          {"uncertified", comparison.uncertified},
          {"largest_gap_over_bound", comparison.largest_gap_over_bound},
          {"max_abs_difference", comparison.largest_difference},
          {"first_difference", comparison.first ? to_json(*comparison.first) : nlohmann::json()},
          {"tier", name_of(comparison.tier)},
          {"verdict", name_of(comparison.verdict)},
          {"reason", comparison.reason}};
}

/// 1234567 as 1,234,567.
std::string grouped(std::int64_t value) {
  std::string digits = std::to_string(value);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<std::size_t>(at), ",");
  }
  return digits;
}

std::string differing(const Comparison& comparison) {
  if (comparison.verdict == Verdict::skipped) {
    return "-";
  }
  return fmt::format("{} of {}", grouped(comparison.sites_differing), grouped(comparison.sites_compared));
}

/// For both modes of a backend, where nothing needs to be told apart, or for one.
void explain(const Comparison& comparison, std::string_view modes) {
  fmt::print("  {}{}: {}", comparison.backend, modes, name_of(comparison.verdict));
  if (comparison.verdict == Verdict::certified) {
    fmt::print(": {} differing site{} within the bound of rounding, the nearest to it at {:.2g} of the bound",
               grouped(comparison.certified_ties), comparison.certified_ties == 1 ? "" : "s",
               comparison.largest_gap_over_bound);
  }
  fmt::print("{}{}\n", comparison.reason.empty() ? "" : ": ", comparison.reason);
}

void explain_disagreement(const Scene& scene, const Comparison& comparison,
                          const CommonArguments& arguments) {
  if (comparison.not_finite > 0) {
    fmt::print("    {} sites are NaN or infinite\n", grouped(comparison.not_finite));
  }
  if (comparison.uncertified > 0) {
    fmt::print("    {} of {} differing sites are not explained by rounding\n",
               grouped(comparison.uncertified), grouped(comparison.sites_differing));
  }
  if (comparison.first) {
    const FirstDifference& first = *comparison.first;
    fmt::print("    first: level {}, iteration {}, x = {}, y = {}: expected ({}, {}), found ({}, {}) px\n",
               first.level, first.iteration, first.x, first.y, first.expected[0], first.expected[1],
               first.found[0], first.found[1]);
    fmt::print("    energy of that site (double): {} before, {} expected, {} found\n", first.energy_before,
               first.energy_expected, first.energy_found);
  }
  if (comparison.counts_differing > 0) {
    fmt::print("    the number of changed sites was wrong after {} iterations\n",
               grouped(comparison.counts_differing));
  }
  fmt::print("    repeat: {}\n", arguments.repeat("verify", scene, comparison.backend));
}

void explain(const Scene& scene, const Comparison& resync, const Comparison& free,
             const CommonArguments& arguments) {
  if (resync.verdict == free.verdict &&
      (resync.verdict == Verdict::skipped || resync.verdict == Verdict::mistrusted)) {
    explain(resync, "");
    return;
  }
  for (const Comparison* comparison : {&resync, &free}) {
    if (comparison->verdict != Verdict::agree) {
      explain(*comparison, fmt::format(" ({})", name_of(comparison->mode)));
    }
    if (comparison->verdict == Verdict::disagree) {
      explain_disagreement(scene, *comparison, arguments);
    }
  }
}

std::string verdict_of_both(const Comparison& resync, const Comparison& free) {
  const Verdict worst = std::max(resync.verdict, free.verdict);
  return worst == Verdict::agree ? fmt::format("agree, {}", name_of(resync.tier))
                                 : std::string(name_of(worst));
}

/// Two comparisons, resync and free, of one backend as one row.
void print_scene(const Scene& scene, const std::vector<Comparison>& comparisons,
                 const CommonArguments& arguments) {
  const auto ran = std::ranges::find_if_not(
      comparisons, [](const Comparison& comparison) { return comparison.verdict == Verdict::skipped; });
  fmt::print("\n{}, {} x {}, {}", scene.name, scene.extent().width, scene.extent().height,
             method_name(scene.schedule));
  if (ran != comparisons.end()) {
    fmt::print(": {} level{}, {} iterations{}{}", ran->levels, ran->levels == 1 ? "" : "s", ran->iterations,
               ran->sweeps == ran->iterations ? "" : fmt::format(" in {} sweeps", ran->sweeps),
               arguments.quick ? " (quick)" : "");
  }
  fmt::print("\n");
  Table table({{"backend", Table::Align::left},
               {"device", Table::Align::left},
               {"differing, resync", Table::Align::right},
               {"differing, free", Table::Align::right},
               {"wrong counts", Table::Align::right},
               {"verdict", Table::Align::left}});
  for (std::size_t i = 0; i + 1 < comparisons.size(); i += 2) {
    const Comparison& resync = comparisons[i];
    const Comparison& free = comparisons[i + 1];
    table.add(
        {resync.backend, resync.device.name, differing(resync), differing(free),
         resync.verdict == Verdict::skipped ? "-" : grouped(resync.counts_differing + free.counts_differing),
         verdict_of_both(resync, free)});
  }
  fmt::print("{}", table.text());
  for (std::size_t i = 0; i + 1 < comparisons.size(); i += 2) {
    const Comparison& resync = comparisons[i];
    const Comparison& free = comparisons[i + 1];
    explain(scene, resync, free, arguments);
  }
}

/// What all comparisons come to, by backend.
void print_tiers(std::span<const Comparison> comparisons) {
  Table table({{"backend", Table::Align::left},
               {"tier reached", Table::Align::left},
               {"comparisons", Table::Align::right},
               {"of them exact", Table::Align::right},
               {"sites compared", Table::Align::right},
               {"differing", Table::Align::right},
               {"certified", Table::Align::right},
               {"uncertified", Table::Align::right}});
  for (const BackendTier& row : tiers_reached(comparisons)) {
    if (row.comparisons == 0) {
      table.add({row.backend, "skipped", "-", "-", "-", "-", "-", "-"});
      continue;
    }
    table.add({row.backend, std::string(name_of(row.tier)), grouped(row.comparisons), grouped(row.exact),
               grouped(row.sites_compared), grouped(row.sites_differing), grouped(row.certified_ties),
               grouped(row.uncertified)});
  }
  fmt::print("\nAll scenes, both modes\n{}", table.text());
}

/// Without scenes and methods on the command line: every scene as its file says, and on the scene that has a
/// different modulus at every site a few iterations of every other method, so that each rule and order of
/// sites is compared. Of several methods those that go to and fro between the levels are left out: bench
/// compares them.
std::vector<Scene> scenes_to_verify(CommonArguments arguments) {
  std::vector<Scene> scenes = arguments.load_scenes(shipped_scenes());
  if (arguments.scenes.empty() && arguments.methods.empty() && !arguments.schedule.method) {
    constexpr int few = 5;
    arguments.scenes = {"random"};
    for (const Method& method : methods()) {
      if (method.name != "icm") {
        arguments.methods.emplace_back(method.name);
      }
    }
    for (Scene& scene : arguments.load_scenes({})) {
      scene.schedule.iterations = std::min(scene.schedule.iterations, few);
      scenes.push_back(std::move(scene));
    }
  }
  std::erase_if(scenes, [&](const Scene& scene) {
    const bool cycles = scene.schedule.cycle != Cycle::one_way;
    const bool named = arguments.schedule.method.has_value(); // then verify() refuses it
    return cycles && !named;
  });
  return scenes;
}

int run_verify(const CommonArguments& arguments, Tier required, const std::string& line) {
  if (!arguments.json.empty()) {
    require_writable(arguments.json);
  }
  const auto registry = make_backends();
  const std::vector<const Backend*> backends = arguments.choose(registry);
  const std::vector<Scene> scenes = scenes_to_verify(arguments);
  VerifyOptions options{.session = arguments.session, .iteration_limit = std::nullopt};
  if (arguments.quick) {
    options.iteration_limit = quick_iterations;
  }
  Progress progress;
  double total = 0.0;
  for (const Scene& scene : scenes) {
    total += site_updates(scene, options.iteration_limit);
  }
  progress.set_total(total, WorkUnit::site_updates);

  nlohmann::json rows = nlohmann::json::array();
  std::vector<Comparison> all;
  for (const Scene& scene : scenes) {
    const std::vector<Comparison> comparisons =
        verify(scene, *backends.front(), std::span(backends).subspan(1), options, progress);
    progress.clear();
    print_scene(scene, comparisons, arguments);
    std::fflush(stdout); // into a pipe too: the next scene may take long
    for (const Comparison& comparison : comparisons) {
      rows.push_back(to_json(scene, comparison));
      all.push_back(comparison);
    }
  }
  print_tiers(all);
  const auto count = [&](Verdict verdict) { return std::ranges::count(all, verdict, &Comparison::verdict); };
  const auto failing = std::ranges::count_if(all, [&](const Comparison& comparison) {
    return comparison.verdict != Verdict::skipped && comparison.tier < required;
  });
  fmt::print(
      "\n{} comparisons with scalar agree to the bit, {} are certified, {} disagree, {} are mistrusted, "
      "{} were skipped\n",
      count(Verdict::agree), count(Verdict::certified), count(Verdict::disagree), count(Verdict::mistrusted),
      count(Verdict::skipped));
  if (required == Tier::bitwise && count(Verdict::certified) > 0) {
    fmt::print("--require-tier bitwise: certified is not enough\n");
  }
  if (!arguments.json.empty()) {
    write_results(arguments.json, "verify", run_context(line, arguments.quick), std::move(rows));
  }
  return failing > 0 ? disagreement : success;
}

} // namespace

void add_verify(CLI::App& program, const std::string& arguments, int& status) {
  auto* command = program.add_subcommand(
      "verify", "Run every backend beside scalar and compare all sites after every iteration, bit for bit.\n"
                "resync: each iteration starts from scalar's field. free: each backend runs on its own.\n"
                "A site that differs is certified where a bound of rounding, derived from the operations at\n"
                "that site, explains the difference; never on a scene whose arithmetic is exact.\n"
                "Exit status 1 if a backend disagrees or a scene could not have shown it.");
  const auto own = std::make_shared<CommonArguments>();
  const auto required = std::make_shared<std::string>(name_of(Tier::certified));
  own->add_to(*command);
  command
      ->add_option("--require-tier", *required,
                   "certified: differences that rounding explains pass. bitwise: none does")
      ->check(CLI::IsMember({"certified", "bitwise"}))
      ->capture_default_str();
  command->callback([own, required, arguments, &status] {
    status = run_verify(*own, *required == "bitwise" ? Tier::bitwise : Tier::certified, arguments);
  });
}

} // namespace hdmbench::commands
