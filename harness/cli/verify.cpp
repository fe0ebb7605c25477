#include "harness/check/verify.hpp"

#include "harness/check/cases.hpp"
#include "harness/check/probe.hpp"
#include "harness/cli/gates.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/report/ci_files.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/solve.hpp"

#include <cmath>
#include <cstdio>
#include <map>

namespace hdmbench::commands {

namespace {

/// Iterations per level of a --quick verify.
constexpr int quick_iterations = 10;

struct VerifyArguments : CommonArguments {
  std::filesystem::path junit{}; ///< empty: nobody asked for it
  std::string reference{};       ///< empty: scalar
  std::string required_tier{name_of(Tier::certified)};

  /// Nobody chose on the command line.
  [[nodiscard]] bool are_all() const {
    return scenes.empty() && methods.empty() && !schedule.method && schedule.energy == nullptr;
  }
};

/// Without scenes and methods on the command line verify_cases(), those that have no size of their own at
/// each of --sizes. One whose files are not on this machine is left out, which is printed.
std::vector<Scene> scenes_to_verify(const VerifyArguments& arguments) {
  if (!arguments.are_all()) {
    return arguments.load_scenes(shipped_scenes());
  }
  std::vector<Scene> scenes;
  std::vector<std::optional<Extent>> sizes(std::max<std::size_t>(arguments.sizes.size(), 1));
  std::ranges::transform(arguments.sizes, sizes.begin(), parse_size);
  for (Case one : verify_cases(arguments.quick)) {
    for (const auto& size : one.size ? std::vector{one.size} : sizes) {
      one.size = size;
      try {
        Scene scene = load_case(one);
        if (!scene.energy->is_of_cells()) {
          arguments.schedule.apply(scene);
          limit_iterations(scene, one);
        }
        scenes.push_back(std::move(scene));
      } catch (const MissingFile& error) {
        fmt::print("{} is left out: {}\n", one.scene, error.what());
      }
    }
  }
  return scenes;
}

/// A row a backend, its modes side by side, with the worst verdict of those that ran.
json rows_by_backend(const std::vector<Comparison>& comparisons) {
  json rows = json::array();
  std::map<std::string, Verdict> worst;
  for (const Comparison& comparison : comparisons) {
    if (rows.empty() || rows.back()["backend"] != comparison.backend) {
      rows.push_back(
          {{"backend", comparison.backend}, {"device", comparison.device.name}, {"verdict", "skipped"}});
    }
    if (comparison.verdict == Verdict::skipped) {
      continue;
    }
    json& row = rows.back();
    row["sites"] = row.value("sites", std::int64_t{0}) + comparison.sites_compared;
    row["counts"] = row.value("counts", std::int64_t{0}) + comparison.counts_differing;
    row[std::string(name_of(comparison.mode))] = comparison.sites_differing;
    const auto [known, is_first] = worst.try_emplace(comparison.backend, comparison.verdict);
    if (is_first || comparison.verdict > known->second) {
      known->second = comparison.verdict;
      row["verdict"] = comparison.verdict == Verdict::agree
                           ? fmt::format("agree, {}", name_of(comparison.tier))
                           : std::string(name_of(comparison.verdict));
    }
  }
  return rows;
}

/// Where bits differ: how many sites and why, the first of them, and the command line that repeats it.
void explain_disagreement(const Scene& scene, const Comparison& comparison, const std::string& repeat) {
  fmt::print("    {} sites are NaN or infinite, {} of {} differing sites are not explained by rounding\n",
             grouped(comparison.not_finite), grouped(comparison.uncertified),
             grouped(comparison.sites_differing));
  if (comparison.first) {
    const FirstDifference& first = *comparison.first;
    const std::string when = first.step.empty() ? fmt::format("iteration {}", first.iteration)
                                                : fmt::format("step {}, {}", first.iteration, first.step);
    fmt::print("    first: level {}, {}, x = {}, y = {}: expected ({}, {}), found ({}, {})\n", first.level,
               when, first.x, first.y, first.expected[0], first.expected[1], first.found[0], first.found[1]);
  }
  if (comparison.counts_differing > 0) {
    fmt::print("    {} {}\n", grouped(comparison.counts_differing),
               scene.energy->is_of_cells() ? "sums over the image are wrong"
                                           : "counts of changed sites are wrong");
  }
  fmt::print("    repeat: {}\n", repeat);
}

/// What was not compared or does not agree, modes for which the same is to be said together.
void explain(const Scene& scene, const std::vector<Comparison>& comparisons,
             const CommonArguments& arguments) {
  for (const Mode mode : {Mode::active, Mode::pyramid}) {
    if (const std::string reason = why_left_out(mode, scene); !reason.empty()) {
      fmt::print("  {} is not compared: {}\n", name_of(mode), reason);
    }
  }
  for (auto first = comparisons.begin(); first != comparisons.end();) {
    const auto says_more = [&](const Comparison& other) {
      return other.backend != first->backend || other.verdict != first->verdict ||
             other.reason != first->reason || other.verdict == Verdict::disagree;
    };
    const auto last = std::find_if(first + 1, comparisons.end(), says_more);
    if (first->verdict != Verdict::agree) {
      const auto all = std::ranges::count(comparisons, first->backend, &Comparison::backend);
      std::string modes;
      for (auto one = first; one != last; ++one) {
        modes += fmt::format("{}{}", modes.empty() ? "" : ", ", name_of(one->mode));
      }
      fmt::print(
          "  {}{}: {}{}{}\n", first->backend, last - first == all ? "" : " (" + modes + ")",
          name_of(first->verdict),
          first->verdict == Verdict::certified
              ? fmt::format(": {} differing sites, the nearest to its bound of rounding at {:.2g} of it",
                            grouped(first->certified_ties), first->largest_gap_over_bound)
              : "",
          first->reason.empty() ? "" : ": " + first->reason);
    }
    if (first->verdict == Verdict::disagree) {
      explain_disagreement(scene, *first, arguments.repeat("verify", scene, first->backend));
    }
    first = last;
  }
}

/// What the comparisons of a scene came to: a row for each backend, and what is to be said of them.
void print_scene(const Scene& scene, const std::vector<Comparison>& comparisons,
                 const CommonArguments& arguments) {
  fmt::print("\n{}, {} x {}, {}", scene.name, scene.extent().width, scene.extent().height,
             method_name(scene));
  const auto ran = std::ranges::find_if(
      comparisons, [](const Comparison& comparison) { return comparison.verdict != Verdict::skipped; });
  if (ran != comparisons.end()) {
    fmt::print(": {} levels, {} iterations in {} {}{}", ran->levels, ran->iterations, ran->sweeps,
               scene.energy->is_of_cells() ? "steps" : "sweeps", arguments.quick ? " (quick)" : "");
  }
  fmt::print("\n{}",
             table_text(rows_by_backend(comparisons),
                        "backend|device|sites:sites compared|resync:differing, resync|free:differing, "
                        "free|active:differing, active|pyramid:differing, pyramid|counts:wrong counts or "
                        "sums|verdict"));
  explain(scene, comparisons, arguments);
  std::fflush(stdout); // into a pipe too: the next scene may take long
}

/// What all comparisons come to, by backend.
void print_tiers(std::span<const Comparison> comparisons) {
  json rows = json::array();
  for (const BackendTier& row : tiers_reached(comparisons)) {
    rows.push_back(
        {{"backend", row.backend}, {"tier", row.comparisons == 0 ? "skipped" : name_of(row.tier)}});
    if (row.comparisons > 0) {
      rows.back().update({{"comparisons", row.comparisons},
                          {"exact", row.exact},
                          {"sites_compared", row.sites_compared},
                          {"differing", row.sites_differing},
                          {"certified", row.certified_ties},
                          {"uncertified", row.uncertified}});
    }
  }
  fmt::print("\nAll scenes, all modes\n{}",
             table_text(rows, "backend|tier:tier reached|comparisons|exact:of them exact|sites_compared|"
                              "differing|certified|uncertified"));
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

/// Backends and scenes, judged and printed. `backends`: the reference first. `speaks`: shows progress.
int verify_scenes(const VerifyArguments& arguments, const std::string& line,
                  const std::vector<const Backend*>& backends, const std::vector<Scene>& scenes,
                  bool speaks = true) {
  Progress progress(speaks);
  VerifyOptions options{.session = arguments.session, .iteration_limit = std::nullopt};
  if (arguments.quick) {
    options.iteration_limit = quick_iterations;
  }
  double total = 0.0;
  for (const Scene& scene : scenes) {
    total += site_updates(scene, options.iteration_limit);
  }
  progress.set_total(total);

  json rows = json::array();
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
    for (const Comparison& comparison : comparisons) {
      VerifyRow row = verify_row(scene, comparison);
      if (const RankBackend* const shared = rank_backend(backends, comparison.backend)) {
        row.backend = shared->backends();
        row.ranks = shared->ranks();
      }
      row.reference = arguments.reference;
      row.repeat = arguments.repeat("verify", scene, comparison.backend) +
                   (arguments.reference.empty() ? "" : " --reference " + arguments.reference);
      rows.push_back(to_json_row(row));
      all.push_back(comparison);
    }
  }
  print_tiers(all);
  print_findings(std::span(backends).subspan(1), all, arguments.session);
  const auto count = [&](Verdict verdict) { return std::ranges::count(all, verdict, &Comparison::verdict); };
  const Tier required = arguments.required_tier == "bitwise" ? Tier::bitwise : Tier::certified;
  const auto failing = std::ranges::count_if(all, [&](const Comparison& comparison) {
    return comparison.verdict != Verdict::skipped && comparison.tier < required;
  });
  fmt::print("\n{} comparisons with {} agree to the bit, {} are certified, {} disagree, {} are mistrusted, "
             "{} were skipped\n",
             count(Verdict::agree), backends.front()->name(), count(Verdict::certified),
             count(Verdict::disagree), count(Verdict::mistrusted), count(Verdict::skipped));
  if (required == Tier::bitwise && count(Verdict::certified) > 0) {
    fmt::print("--require-tier bitwise: certified is not enough\n");
  }
  report::write_junit(arguments.junit, rows);
  write_results(arguments.json, "verify", run_context(line, arguments.quick), std::move(rows));
  return failing > 0 ? disagreement : success;
}

int run_verify(const VerifyArguments& arguments, const std::string& line) {
  require_results_writable(arguments.json);
  require_results_writable(arguments.junit);
  const auto registry = make_backends();
  if (!arguments.reference.empty()) {
    (void)find_backend(registry, arguments.reference); // "none" is none
  }
  return verify_scenes(arguments, line, arguments.choose(registry, arguments.reference),
                       scenes_to_verify(arguments));
}

/// Without those that several ranks cannot compute, which it names, and where nobody chose with what sleeps
/// on so many ranks.
std::vector<Scene> scenes_for_ranks(const VerifyArguments& arguments, int ranks) {
  std::vector<Scene> scenes = scenes_to_verify(arguments);
  if (arguments.are_all()) {
    scenes.push_back(sleeping_pieces(ranks));
  }
  std::erase_if(scenes, [](const Scene& scene) {
    const bool is_sequential = scene.full.update == Update::sequential;
    if (is_sequential) {
      fmt::print("{}, {}, is left out: sequential updates cross the image in one sweep\n", scene.name,
                 method_name(scene));
    }
    return is_sequential;
  });
  return scenes;
}

/// Every backend on 1, 2, ... ranks, against scalar, which every rank computes for itself.
int run_verify_on_ranks(VerifyArguments arguments, const std::string& line, Ranks& ranks) {
  if (!arguments.reference.empty()) {
    throw InputError("verify --reference runs in one process: leave out mpirun");
  }
  if (ranks.is_first()) {
    require_results_writable(arguments.json);
    require_results_writable(arguments.junit);
  } else { // results are the first one's to write
    arguments.json.clear();
    arguments.junit.clear();
  }
  const auto registry = make_backends();
  std::vector<std::string> names = arguments.backends;
  for (std::size_t i = 0; i < registry.size() && arguments.backends.empty(); ++i) {
    names.emplace_back(registry[i]->name());
  }
  const SessionOptions asked = std::exchange(arguments.session, {});
  // Levels are shared out down to 8 x 8 sites a rank: below, one after the other has fewer ranks.
  constexpr std::size_t fewest_sites = 64;
  std::vector<std::unique_ptr<RankBackend>> shared;
  std::vector<const Backend*> backends{registry.front().get()};
  for (const std::string& name : names) {
    for (int pieces = 1; pieces <= ranks.size(); ++pieces) {
      const Sharing sharing{.pieces = pieces, .fewest_sites = fewest_sites};
      shared.push_back(std::make_unique<RankBackend>(ranks, registry, name, asked, sharing));
      backends.push_back(shared.back().get());
    }
  }
  return verify_scenes(arguments, line, backends, scenes_for_ranks(arguments, ranks.size()),
                       ranks.is_first());
}

} // namespace

void add_verify(CLI::App& program, Call& call) {
  CLI::App* const command = program.add_subcommand(
      "verify",
      "Run every backend beside scalar and compare all sites after every iteration, bit for bit.\n"
      "resync: each iteration starts from scalar's field. free: each backend runs on its own.\n"
      "active: free, leaving out what cannot change. pyramid: all levels in one call, the last field.\n"
      "A site that differs is certified where a bound of rounding, derived from the operations at\n"
      "that site, explains the difference; never on a scene whose arithmetic is exact.\n"
      "Without scenes: all of them, the other methods, and three sizes that meet the backends' tiles.\n"
      "mpirun -n R hdmbench verify: every backend, or mixture as openmp+vulkan-compute, on 1 ... R ranks.\n"
      "Exit status 1 if a backend disagrees or a scene could not have shown it.");
  const auto own = std::make_shared<VerifyArguments>();
  own->schedule.takes_energy = true;
  own->add_to(*command);
  add_option(*command, "--require-tier", own->required_tier,
             "certified: differences that rounding explains pass. bitwise: none does")
      ->check(CLI::IsMember({"certified", "bitwise"}));
  add_option(*command, "--junit", own->junit, "Write the comparisons to this file as JUnit XML, too, for CI");
  add_option(
      *command, "--reference", own->reference,
      "Backend that the others are compared with (default: scalar, which takes minutes beyond 4096 x 4096)");
  const auto gates = std::make_shared<Gates>();
  gates->add_to(*command, true);
  command->callback([own, gates, &call] {
    gates->prepare(*own);
    if (call.ranks == nullptr) {
      call.status = gates->judge(run_verify(*own, call.line), *own);
      return;
    }
    call.status = run_verify_on_ranks(*own, call.line, *call.ranks);
    call.status = call.ranks->is_first() ? gates->judge(call.status, *own) : call.status;
  });
}

} // namespace hdmbench::commands
