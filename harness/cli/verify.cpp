#include "harness/check/tiers.hpp"
#include "harness/check/tile_boundaries.hpp"
#include "harness/check/verify_row.hpp"

#include "harness/check/probe.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/verify_windows.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/ranks/rank_devices.hpp"
#include "harness/report/grouped.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/joined.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace hdmbench::commands {

namespace {

/// For all modes of a backend, where nothing needs to be told apart, or for one.
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
    const std::string when = first.step.empty() ? fmt::format("iteration {}", first.iteration)
                                                : fmt::format("step {}, {}", first.iteration, first.step);
    fmt::print("    first: level {}, {}, x = {}, y = {}: expected ({}, {}), found ({}, {})\n", first.level,
               when, first.x, first.y, first.expected[0], first.expected[1], first.found[0], first.found[1]);
    if (first.step.empty()) {
      fmt::print("    energy of that site (double): {} before, {} expected, {} found\n", first.energy_before,
                 first.energy_expected, first.energy_found);
    }
  }
  if (comparison.counts_differing > 0) {
    fmt::print(scene.energy == EnergyModel::elastic
                   ? fmt::runtime("    {} sums over the image are wrong\n")
                   : fmt::runtime("    the number of changed sites was wrong after {} iterations\n"),
               grouped(comparison.counts_differing));
  }
  fmt::print("    repeat: {}\n", arguments.repeat("verify", scene, comparison.backend));
}

/// The comparisons of one backend, one per mode.
using Modes = std::span<const Comparison>;

bool is_skipped(const Comparison& comparison) {
  return comparison.verdict == Verdict::skipped;
}

void explain(const Scene& scene, Modes modes, const CommonArguments& arguments) {
  const Comparison& first = modes.front();
  const bool all_alike = std::ranges::all_of(modes, [&](const Comparison& comparison) {
    return comparison.verdict == first.verdict && comparison.reason == first.reason;
  });
  if (all_alike && (is_skipped(first) || first.verdict == Verdict::mistrusted)) {
    explain(first, "");
    return;
  }
  for (const Comparison& comparison : modes) {
    if (comparison.verdict != Verdict::agree) {
      explain(comparison, fmt::format(" ({})", name_of(comparison.mode)));
    }
    if (comparison.verdict == Verdict::disagree) {
      explain_disagreement(scene, comparison, arguments);
    }
  }
}

/// The worst of those that ran.
std::string verdict_of(Modes modes) {
  const Comparison* worst = nullptr;
  for (const Comparison& comparison : modes) {
    if (!is_skipped(comparison) && (worst == nullptr || comparison.verdict > worst->verdict)) {
      worst = &comparison;
    }
  }
  const Verdict verdict = worst == nullptr ? Verdict::skipped : worst->verdict;
  return verdict == Verdict::agree ? fmt::format("agree, {}", name_of(worst->tier))
                                   : std::string(name_of(verdict));
}

/// Which modes are not compared on any backend, and how much of the work active may leave out.
void print_remarks(const Scene& scene, const std::vector<Comparison>& comparisons) {
  if (scene.robust) {
    fmt::print("  observations are forgiven by solving again with other springs: followed is the first "
               "solution\n");
  }
  for (const Mode mode : {Mode::active, Mode::pyramid}) {
    if (const std::string reason = why_left_out(mode, scene); !reason.empty()) {
      fmt::print("  {} is not compared: {}\n", name_of(mode), reason);
    }
  }
  for (const Comparison& comparison : comparisons) {
    if (!comparison.coarse_levels.empty()) {
      fmt::print("  pyramid on {}: coarse levels by {}\n", comparison.backend,
                 joined(comparison.coarse_levels, ", and by "));
    }
  }
  const auto rested = std::ranges::find_if(
      comparisons, [](const Comparison& comparison) { return comparison.sites_at_rest > 0; });
  if (rested != comparisons.end()) {
    fmt::print("  active: tiles of 16 x 16 are at rest in {:.1f} % of the site updates\n",
               100.0 * static_cast<double>(rested->sites_at_rest) /
                   static_cast<double>(rested->sites_compared));
  }
}

/// One row per backend.
void print_scene(const Scene& scene, const std::vector<Comparison>& comparisons,
                 const CommonArguments& arguments) {
  const auto ran = std::ranges::find_if_not(comparisons, is_skipped);
  fmt::print("\n{}, {} x {}, {}", scene.name, scene.extent().width, scene.extent().height,
             method_name(scene));
  if (ran != comparisons.end()) {
    fmt::print(
        ": {} level{}, {} iterations{}{}", ran->levels, ran->levels == 1 ? "" : "s", ran->iterations,
        ran->sweeps == ran->iterations
            ? ""
            : fmt::format(" in {} {}", ran->sweeps, scene.energy == EnergyModel::hdm ? "sweeps" : "steps"),
        arguments.quick ? " (quick)" : "");
  }
  fmt::print("\n");
  std::vector<Modes> backends;
  for (auto first = comparisons.begin(); first != comparisons.end();) {
    const auto last = std::find_if(first + 1, comparisons.end(), [](const Comparison& comparison) {
      return comparison.mode == Mode::resync;
    });
    backends.emplace_back(first, last);
    first = last;
  }
  std::vector<Table::Column> columns{
      {"backend", Table::Align::left}, {"device", Table::Align::left}, {"sites compared"}};
  std::vector<Mode> modes_here;
  for (const Mode mode : {Mode::resync, Mode::free, Mode::active, Mode::pyramid}) {
    if (std::ranges::find(comparisons, mode, &Comparison::mode) != comparisons.end()) {
      modes_here.push_back(mode);
      columns.push_back({fmt::format("differing, {}", name_of(mode))});
    }
  }
  columns.push_back({scene.energy == EnergyModel::elastic ? "wrong sums" : "wrong counts"});
  columns.push_back({"verdict", Table::Align::left});
  Table table(columns);
  for (const Modes modes : backends) {
    std::vector<std::string> differing(modes_here.size(), "-");
    std::int64_t compared = 0;
    std::int64_t wrong_counts = 0;
    for (const Comparison& comparison : modes) {
      compared += comparison.sites_compared;
      wrong_counts += comparison.counts_differing;
      if (!is_skipped(comparison)) {
        const auto column = std::ranges::find(modes_here, comparison.mode) - modes_here.begin();
        differing.at(static_cast<std::size_t>(column)) = grouped(comparison.sites_differing);
      }
    }
    const bool ran_at_all = !std::ranges::all_of(modes, is_skipped);
    std::vector<std::string> cells{modes.front().backend, modes.front().device.name,
                                   ran_at_all ? grouped(compared) : "-"};
    cells.insert(cells.end(), differing.begin(), differing.end());
    cells.push_back(ran_at_all ? grouped(wrong_counts) : "-");
    cells.push_back(verdict_of(modes));
    table.add(std::move(cells));
  }
  fmt::print("{}", table.text());
  print_remarks(scene, comparisons);
  for (const Modes modes : backends) {
    explain(scene, modes, arguments);
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
  fmt::print("\nAll scenes, all modes\n{}", table.text());
}

/// Without scenes and methods on the command line: every scene as its file says, what meets the backends'
/// tiles at any --sizes, and on the scene that has a different modulus at every site a few iterations of
/// every other method, so that each rule and order of sites is compared; then every scene (--quick: two of
/// them) with the elastic energy, a few steps of conjugate gradients, in which all of its arithmetic is. Of
/// several methods those that go to and fro between the levels are left out: bench compares them.
std::vector<Scene> scenes_to_verify(CommonArguments arguments) {
  std::vector<Scene> scenes = arguments.load_scenes(shipped_scenes());
  const bool all = arguments.scenes.empty() && arguments.methods.empty();
  if (all && !arguments.schedule.method && !arguments.schedule.energy) {
    for (Scene& scene : tile_boundary_scenes()) {
      arguments.schedule.apply(scene);
      scenes.push_back(std::move(scene));
    }
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
    arguments.scenes.clear();
    arguments.methods = {std::string(elastic_conjugate_gradients)};
    arguments.schedule = ScheduleOverrides{};
    arguments.schedule.takes_elastic = true;
    arguments.schedule.iterations = 2;
    // A shorter run has a modulus at every site, and a region that is prescribed.
    const std::vector<std::string> two{"random", "circular-radial"};
    for (Scene& scene : arguments.load_scenes(arguments.quick ? two : shipped_scenes())) {
      scenes.push_back(std::move(scene));
    }
  }
  std::erase_if(scenes, [&](const Scene& scene) {
    const bool cycles = scene.energy == EnergyModel::hdm && scene.schedule.cycle != Cycle::one_way;
    const bool named = arguments.schedule.method.has_value(); // then verify() refuses it
    return cycles && !named;
  });
  return scenes;
}

/// Where bits differ, what the device's arithmetic may have to do with it.
void print_findings(std::span<const Backend* const> backends, const std::vector<Comparison>& all,
                    const SessionOptions& session) {
  for (const Backend* const backend : backends) {
    const bool differs = std::ranges::any_of(all, [&](const Comparison& comparison) {
      return comparison.backend == backend->name() && comparison.sites_differing > 0;
    });
    if (!differs) {
      continue;
    }
    try {
      const std::vector<ProbeRow> rows = probe(*backend, session);
      const std::string found = findings(rows);
      fmt::print("\nBits of {} differ. Its arithmetic, as probe finds it, lets one expect {}\n{}",
                 backend->name(), expected_tier(rows),
                 found.empty() ? "" : fmt::format("  not as specified: {}\n", found));
    } catch (const DeviceError& error) {
      fmt::print("\nBits of {} differ. probe could not ask it: {}\n", backend->name(), error.what());
    }
  }
}

/// The one of this name; null where it runs in one process.
const RankBackend* rank_backend(const std::vector<const Backend*>& backends, std::string_view name) {
  return dynamic_cast<const RankBackend*>(*std::ranges::find(backends, name, &Backend::name));
}

/// Backends and scenes, judged and printed. `backends`: the reference first.
int verify_scenes(const CommonArguments& arguments, Tier required, const std::string& line,
                  const std::vector<const Backend*>& backends, const std::vector<Scene>& scenes) {
  Progress progress;
  VerifyOptions options{.session = arguments.session, .iteration_limit = std::nullopt};
  if (arguments.quick) {
    options.iteration_limit = quick_iterations;
  }
  double total = 0.0;
  for (const Scene& scene : scenes) {
    total += site_updates(scene, options.iteration_limit);
  }
  progress.set_total(total, WorkUnit::site_updates);

  nlohmann::json rows = nlohmann::json::array();
  std::vector<Comparison> all;
  for (const Scene& scene : scenes) {
    std::vector<Comparison> comparisons =
        verify(scene, *backends.front(), std::span(backends).subspan(1), options, progress);
    progress.clear();
    for (Comparison& comparison : comparisons) {
      const RankBackend* const shared = rank_backend(backends, comparison.backend);
      if (shared != nullptr && shared->has_bits_of_scalar()) {
        excuse_nothing(comparison);
      }
    }
    print_scene(scene, comparisons, arguments);
    std::fflush(stdout); // into a pipe too: the next scene may take long
    for (const Comparison& comparison : comparisons) {
      VerifyRow row = verify_row(scene, comparison);
      if (const RankBackend* const shared = rank_backend(backends, comparison.backend)) {
        row.backend = shared->backends();
        row.ranks = shared->ranks();
      }
      rows.push_back(to_json_row(row));
      all.push_back(comparison);
    }
  }
  print_tiers(all);
  print_findings(std::span(backends).subspan(1), all, arguments.session);
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

int run_verify(const CommonArguments& arguments, Tier required, const std::string& line) {
  if (!arguments.json.empty()) {
    require_writable(arguments.json);
  }
  const auto registry = make_backends();
  return verify_scenes(arguments, required, line, arguments.choose(registry), scenes_to_verify(arguments));
}

/// Without those that several ranks cannot compute, which it names.
std::vector<Scene> scenes_for_ranks(const CommonArguments& arguments) {
  std::vector<Scene> scenes = scenes_to_verify(arguments);
  std::erase_if(scenes, [](const Scene& scene) {
    std::string_view why;
    if (scene.schedule.rule == Rule::annealing) {
      why = "annealing draws its random numbers by column and row";
    } else if (scene.full.update == Update::sequential) {
      why = "sequential updates cross the image in one sweep";
    }
    if (!why.empty()) {
      fmt::print("{}, {}, is left out: {}\n", scene.name, method_name(scene), why);
    }
    return !why.empty();
  });
  return scenes;
}

/// Every backend on 1, 2, ... ranks, against scalar on the first one.
int run_verify_on_ranks(const CommonArguments& arguments, Tier required, const std::string& line,
                        Ranks& ranks) {
  const auto registry = make_backends();
  Crew crew(ranks, registry, arguments.session);
  if (!ranks.is_first()) {
    crew.serve();
    return success;
  }
  if (!arguments.json.empty()) {
    require_writable(arguments.json);
  }
  std::vector<std::string> names = arguments.backends;
  for (std::size_t i = 0; i < registry.size() && arguments.backends.empty(); ++i) {
    names.emplace_back(registry[i]->name());
  }
  // Levels are shared out down to 8 x 8 sites a rank: below, one after the other has fewer ranks.
  constexpr std::size_t fewest_sites = 64;
  std::vector<std::unique_ptr<RankBackend>> shared;
  std::vector<const Backend*> backends{registry.front().get()};
  for (const std::string& name : names) {
    for (int pieces = 1; pieces <= ranks.size(); ++pieces) {
      shared.push_back(std::make_unique<RankBackend>(
          crew, backend_of_rank(registry, name, 0), name,
          Sharing{.ranks = ranks.size(), .pieces = pieces, .fewest_sites = fewest_sites}));
      backends.push_back(shared.back().get());
    }
  }
  const int status = verify_scenes(arguments, required, line, backends, scenes_for_ranks(arguments));
  crew.dismiss();
  return status;
}

} // namespace

void add_verify(CLI::App& program, const std::string& arguments, int& status, Ranks* ranks) {
  auto* command = program.add_subcommand(
      "verify",
      "Run every backend beside scalar and compare all sites after every iteration, bit for bit.\n"
      "resync: each iteration starts from scalar's field. free: each backend runs on its own.\n"
      "active: free, leaving out what cannot change. pyramid: all levels in one call, the last field.\n"
      "A site that differs is certified where a bound of rounding, derived from the operations at\n"
      "that site, explains the difference; never on a scene whose arithmetic is exact.\n"
      "Without scenes: all of them, the other methods, and three sizes that meet the backends' tiles.\n"
      "mpirun -n R hdmbench verify: every backend, or mixture as openmp+vulkan-compute, on 1 ... R ranks.\n"
      "Exit status 1 if a backend disagrees or a scene could not have shown it.");
  const auto own = std::make_shared<CommonArguments>();
  own->schedule.takes_elastic = true;
  const auto required = std::make_shared<std::string>(name_of(Tier::certified));
  own->add_to(*command);
  command
      ->add_option("--require-tier", *required,
                   "certified: differences that rounding explains pass. bitwise: none does")
      ->check(CLI::IsMember({"certified", "bitwise"}))
      ->capture_default_str();
  const auto windows = std::make_shared<WindowArguments>();
  windows->add_to(*command);
  command->callback([own, required, windows, arguments, &status, ranks] {
    const Tier tier = *required == "bitwise" ? Tier::bitwise : Tier::certified;
    if (ranks != nullptr) {
      if (windows->windows > 0) {
        throw InputError("verify --windows runs in one process: leave out mpirun");
      }
      status = run_verify_on_ranks(*own, tier, arguments, *ranks);
      return;
    }
    if (windows->windows > 0) {
      status = run_verify_windows(*own, *windows, arguments);
      return;
    }
    status = run_verify(*own, tier, arguments);
  });
}

} // namespace hdmbench::commands
