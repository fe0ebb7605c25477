#include "harness/check/cases.hpp"
#include "harness/check/verify_row.hpp"

#include "harness/check/probe.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/gates.hpp"
#include "harness/cli/verify_text.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/ranks/rank_devices.hpp"
#include "harness/ranks/sleeping_pieces.hpp"
#include "harness/report/ci_files.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace hdmbench::commands {

namespace {

struct VerifyArguments : CommonArguments {
  std::filesystem::path junit; ///< empty: nobody asked for it
  std::string reference;       ///< empty: scalar
};

/// Iterations per level of a --quick verify.
constexpr int quick_iterations = 10;

/// Nobody chose on the command line.
bool are_all_to_verify(const CommonArguments& arguments) {
  return arguments.scenes.empty() && arguments.methods.empty() && !arguments.schedule.method &&
         !arguments.schedule.energy;
}

/// The scene of a case, with what the command line says of a schedule of the thesis's energy. None where one
/// of its files is not on this machine, which is printed.
std::optional<Scene> load(const Case& one, const ScheduleOverrides& overrides) {
  try {
    Scene scene = load_case(one);
    if (scene.energy == EnergyModel::hdm) {
      overrides.apply(scene);
      limit_iterations(scene, one);
    }
    return scene;
  } catch (const MissingFile& error) {
    fmt::print("{} is left out: {}\n", one.scene, error.what());
    return std::nullopt;
  }
}

/// Without scenes and methods on the command line verify_cases(), those that have no size of their own at
/// each of --sizes.
std::vector<Scene> scenes_to_verify(const CommonArguments& arguments) {
  std::vector<Scene> scenes;
  if (are_all_to_verify(arguments)) {
    std::vector<std::optional<Extent>> sizes(std::max<std::size_t>(arguments.sizes.size(), 1));
    std::ranges::transform(arguments.sizes, sizes.begin(), parse_size);
    for (Case one : verify_cases(arguments.quick)) {
      for (const auto& size : one.size ? std::vector{one.size} : sizes) {
        one.size = size;
        if (std::optional<Scene> scene = load(one, arguments.schedule)) {
          scenes.push_back(std::move(*scene));
        }
      }
    }
  } else {
    scenes = arguments.load_scenes(shipped_scenes());
  }
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

/// Backends and scenes, judged and printed. `backends`: the reference first. `speaks`: shows progress.
int verify_scenes(const VerifyArguments& arguments, Tier required, const std::string& line,
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

/// The reference first, then what is compared with it. Throws InputError where nothing is.
std::vector<const Backend*> backends_to_verify(const VerifyArguments& arguments,
                                               const std::vector<std::unique_ptr<Backend>>& registry) {
  std::vector<const Backend*> backends = arguments.choose(registry); // scalar first
  if (arguments.reference.empty()) {
    return backends;
  }
  const Backend* const reference = &find_backend(registry, arguments.reference);
  if (std::ranges::find(arguments.backends, backends.front()->name()) == arguments.backends.end()) {
    backends.erase(backends.begin());
  }
  std::erase(backends, reference);
  if (backends.empty()) {
    throw InputError(
        fmt::format("no backend is left to compare with {}; name one with --backends", arguments.reference));
  }
  backends.insert(backends.begin(), reference);
  return backends;
}

int run_verify(const VerifyArguments& arguments, Tier required, const std::string& line) {
  require_results_writable(arguments.json);
  require_results_writable(arguments.junit);
  const auto registry = make_backends();
  return verify_scenes(arguments, required, line, backends_to_verify(arguments, registry),
                       scenes_to_verify(arguments));
}

/// Without those that several ranks cannot compute, which it names, and where nobody chose with what sleeps
/// on so many ranks.
std::vector<Scene> scenes_for_ranks(const CommonArguments& arguments, int ranks) {
  std::vector<Scene> scenes = scenes_to_verify(arguments);
  if (are_all_to_verify(arguments)) {
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
int run_verify_on_ranks(VerifyArguments arguments, Tier required, const std::string& line, Ranks& ranks) {
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
  return verify_scenes(arguments, required, line, backends, scenes_for_ranks(arguments, ranks.size()),
                       ranks.is_first());
}

} // namespace

void add_verify(const Command& program, const std::string& arguments, int& status, Ranks* ranks) {
  const Command command = program.add_subcommand(
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
  own->schedule.takes_elastic = true;
  const auto required = std::make_shared<std::string>(name_of(Tier::certified));
  own->add_to(command);
  command
      .add_option("--require-tier", *required,
                  "certified: differences that rounding explains pass. bitwise: none does")
      .one_of({"certified", "bitwise"})
      .capture_default_str();
  command.add_option("--junit", own->junit, "Write the comparisons to this file as JUnit XML, too, for CI");
  command.add_option(
      "--reference", own->reference,
      "Backend that the others are compared with (default: scalar, which takes minutes beyond 4096 x 4096)");
  const auto gates = std::make_shared<Gates>();
  gates->add_to(command);
  gates->add_baseline_to(command);
  command.callback([own, required, gates, arguments, &status, ranks] {
    gates->prepare(*own);
    const Tier tier = *required == "bitwise" ? Tier::bitwise : Tier::certified;
    if (ranks != nullptr) {
      if (!own->reference.empty()) {
        throw InputError("verify --reference runs in one process: leave out mpirun");
      }
      status = run_verify_on_ranks(*own, tier, arguments, *ranks);
      status = ranks->is_first() ? gates->judge(status, *own) : status;
      return;
    }
    status = gates->judge(run_verify(*own, tier, arguments), *own);
  });
}

} // namespace hdmbench::commands
