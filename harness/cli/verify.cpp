#include "harness/check/verify.hpp"

#include "backends/shared/kept_arithmetic.hpp"
#include "harness/check/cases.hpp"
#include "harness/check/probe.hpp"
#include "harness/check/reproducer/reproducer.hpp"
#include "harness/check/verify_rows.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/report/ci_files.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/solve.hpp"

#include <cmath>
#include <cstdio>
#include <set>
#include <utility>

namespace hdmbench::commands {

namespace {

/// Iterations per level of a --quick verify.
constexpr int quick_iterations = 10;

const Option<OutputFile> junit("--junit", "Write the comparisons to this file as JUnit XML, too, for CI");
const Option<OutputFolder>
    dump("--dump",
         "Where bits differ, write the first such step of each backend to a folder in this one, as a "
         "program that stands alone");
const Option<std::string> reference(
    "--reference",
    "Backend that the others are compared with (default: scalar, which takes minutes beyond 4096 x 4096)");
const Option<std::string>
    required_tier("--require-tier", "certified: differences that rounding explains pass. bitwise: none does",
                  std::string(name_of(Tier::certified)), CLI::IsMember({"certified", "bitwise"}));

/// Nobody chose on the command line.
bool are_all(const Call& call) {
  return call[option::scenes].empty() && call[option::methods].empty() &&
         !call.schedule.given.contains("method") && call.schedule.energy == nullptr;
}

/// Without scenes and methods on the command line verify_cases(), those that have no size of their own at
/// each of --sizes. One whose files are not on this machine is left out, which is printed.
std::vector<Scene> scenes_to_verify(const Call& call) {
  if (!are_all(call)) {
    return load_scenes(call, shipped_scenes());
  }
  std::vector<Scene> scenes;
  std::vector<std::optional<Extent>> sizes(std::max<std::size_t>(call[option::sizes].size(), 1));
  std::ranges::transform(call[option::sizes], sizes.begin(), parse_size);
  for (Case one : verify_cases(call[option::quick])) {
    for (const auto& size : one.size ? std::vector{one.size} : sizes) {
      one.size = size;
      if (auto scene = load_unless_missing(one.scene, false, [&] { return load_case(one); })) {
        if (!scene->energy->is_of_cells()) {
          call.schedule.apply(*scene);
          limit_iterations(*scene, one);
        }
        scenes.push_back(std::move(*scene));
      }
    }
  }
  return scenes;
}

/// A row a backend: what its comparisons come to, and how many sites differ by mode. Skipped ones count as
/// nothing.
json rows_by_backend(std::span<const Comparison> comparisons) {
  json rows = json::array();
  for (const Comparison& one : comparisons) {
    const auto known =
        std::ranges::find_if(rows, [&](const json& row) { return row["backend"] == one.backend; });
    json& row = known != rows.end() ? *known
                                    : rows.emplace_back(json{{"backend", one.backend},
                                                             {"device", one.device.name},
                                                             {"verdict", "skipped"},
                                                             {"tier", "skipped"}});
    if (one.verdict == Verdict::skipped) {
      continue;
    }
    for (const auto& [key, number] : {std::pair<std::string_view, std::int64_t>{"comparisons", 1},
                                      {"exact", one.tier == Tier::exact ? 1 : 0},
                                      {"sites", one.sites_compared},
                                      {name_of(one.mode), one.sites_differing},
                                      {"differing", one.sites_differing},
                                      {"certified", one.certified_ties},
                                      {"uncertified", one.uncertified},
                                      {"counts", one.counts_differing}}) {
      json& sum = row[std::string(key)];
      sum = number + (sum.is_null() ? 0 : sum.get<std::int64_t>());
    }
    row["worst"] = std::max(row.value("worst", Verdict::agree), one.verdict);
    row["lowest"] = std::min(row.value("lowest", Tier::exact), one.tier);
    row["verdict"] = name_of(row["worst"].get<Verdict>());
    row["tier"] = name_of(row["lowest"].get<Tier>());
  }
  return rows;
}

void print_why(const Comparison& comparison) {
  if (!comparison.why.empty()) {
    fmt::print("    why: {}\n", comparison.why);
  }
}

/// Where bits differ: how many sites and why, the first of them, and the command line that repeats it.
void explain_disagreement(const Scene& scene, const Comparison& comparison, const std::string& repeat) {
  fmt::print("    {} sites are NaN or infinite, {} of {} differing sites are not explained by rounding\n",
             grouped(comparison.not_finite), grouped(comparison.uncertified),
             grouped(comparison.sites_differing));
  if (comparison.first) {
    fmt::print("    first: {}\n", comparison.first->text());
  }
  print_why(comparison);
  if (comparison.counts_differing > 0) {
    fmt::print("    {} {}\n", grouped(comparison.counts_differing),
               scene.energy->is_of_cells() ? "sums over the image are wrong"
                                           : "counts of changed sites are wrong");
  }
  fmt::print("    repeat: {}\n", repeat);
}

/// What was not compared or does not agree. The modes of a backend that is skipped for one reason are one
/// line.
void explain_disagreements(const Scene& scene, const std::vector<Comparison>& comparisons, const Call& call) {
  for (const Mode mode : {Mode::active, Mode::pyramid}) {
    if (const std::string reason = why_left_out(mode, scene); !reason.empty()) {
      fmt::print("  {} is not compared: {}\n", name_of(mode), reason);
    }
  }
  std::string with_hosts_laws;
  for (const Comparison& one : comparisons) {
    with_hosts_laws += !one.has_hosts_laws ? "" : (with_hosts_laws.empty() ? "" : ", ") + one.backend;
  }
  if (!with_hosts_laws.empty()) {
    fmt::print("  forces of laws are not compared, they are the host's: {}\n", with_hosts_laws);
  }
  std::set<std::pair<std::string, std::string>> skipped;
  for (const Comparison& one : comparisons) {
    if (one.verdict == Verdict::agree ||
        (one.verdict == Verdict::skipped && !skipped.emplace(one.backend, one.reason).second)) {
      continue;
    }
    fmt::print("  {}{}: {}{}{}\n", one.backend,
               one.device.name.empty() ? "" : fmt::format(" ({})", name_of(one.mode)), name_of(one.verdict),
               one.verdict == Verdict::certified
                   ? fmt::format(": {} differing sites, the nearest to its bound of rounding at {:.2g} of it",
                                 grouped(one.certified_ties), one.largest_gap_over_bound)
                   : "",
               one.reason.empty() ? "" : ": " + one.reason);
    if (one.verdict == Verdict::disagree) {
      explain_disagreement(scene, one, repeat_line(call, scene, one.backend));
    } else {
      print_why(one);
    }
  }
}

/// What the comparisons of a scene came to: a row for each backend, and what is to be said of them.
void print_scene(const Scene& scene, const std::vector<Comparison>& comparisons, const Call& call) {
  fmt::print("\n{}, {}, {}", scene.name, scene.extent().text(), method_name(scene));
  const auto ran = std::ranges::find_if(
      comparisons, [](const Comparison& comparison) { return comparison.verdict != Verdict::skipped; });
  if (ran != comparisons.end()) {
    fmt::print(": {} levels, {} iterations in {} {}{}", ran->levels, ran->iterations, ran->sweeps,
               !scene.energy->is_of_cells() ? "sweeps" : "steps", call[option::quick] ? " (quick)" : "");
  }
  fmt::print("\n{}",
             table_text(rows_by_backend(comparisons),
                        "backend|device|sites:sites compared|resync:differing, resync|free:differing, "
                        "free|active:differing, active|pyramid:differing, pyramid|counts:wrong counts or "
                        "sums|verdict|tier"));
  explain_disagreements(scene, comparisons, call);
  std::fflush(stdout); // into a pipe too: the next scene may take long
}

/// Writes the step in which bits first differed to a folder of --dump, the first of each backend and verdict,
/// and its name into `row`. Returns a line that says where, for people; empty where there is nothing to say.
std::string dump_step(const Call& call, const Comparison& comparison, json& row,
                      std::set<std::string>& dumped) {
  const bool differs = comparison.mode == Mode::resync && comparison.sites_differing > 0;
  const std::string name = fmt::format("{}-{}", comparison.backend, name_of(comparison.verdict));
  if (call[dump].empty() || !differs || dumped.contains(name)) {
    return {};
  }
  if (comparison.step == nullptr) {
    return fmt::format(
        "  dump: no step of {} is kept: only those of compute kernels on a level in one piece are\n",
        comparison.backend);
  }
  dumped.insert(name);
  const std::filesystem::path folder = call[dump] / name;
  write_reproducer(folder, comparison, row["repeat"]);
  row["dump"] = folder;
  return fmt::format("  dump: {}: README.txt says how to run it\n", folder.string());
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

/// What was asked for and not compared, of all comparisons; empty where nothing is missing. `backends`: the
/// reference first.
std::string what_is_missing(const Call& call, const std::vector<const Backend*>& backends,
                            const std::vector<Comparison>& all) {
  const auto failed = std::ranges::find(all, true, &Comparison::failed);
  if (failed != all.end()) {
    return failed->reason;
  }
  const auto is_compared = [&](std::string_view backend) {
    return std::ranges::any_of(all, [&](const Comparison& one) {
      return one.verdict != Verdict::skipped && (backend.empty() || one.backend == backend);
    });
  };
  if (!is_compared("")) {
    return "nothing was compared, so nothing has passed: all comparisons were skipped, for the reasons above";
  }
  for (const Backend* const backend : backends) {
    if (backend != backends.front() && needs(call, backend->name()) && !is_compared(backend->name())) {
      return fmt::format("{} is needed, but nothing was compared on it, for the reasons above",
                         backend->name());
    }
  }
  return {};
}

/// `shared`: the backend where ranks share it; null: in one process.
json row_of(const Call& call, const Scene& scene, const Comparison& comparison, const RankBackend* shared) {
  json row = verify_row(scene, comparison);
  if (shared != nullptr) {
    row["backend"] = shared->backends();
    row["ranks"] = shared->ranks();
  }
  if (const std::string changed = changed_arithmetic(comparison.backend); !changed.empty()) {
    row["changed_arithmetic"] = changed;
  }
  row["repeat"] = repeat_line(call, scene, comparison.backend);
  if (!call[reference].empty()) {
    row["reference"] = call[reference];
    row["repeat"] = fmt::format("{} --reference {}", row["repeat"].get<std::string>(), call[reference]);
  }
  return row;
}

/// Backends and scenes, judged and printed. `backends`: the reference first. Returns an ExitStatus.
int verify_scenes(const Call& call, const std::vector<const Backend*>& backends,
                  const std::vector<Scene>& scenes) {
  Progress progress(call.speaks());
  VerifyOptions options{
      .session = call.session(), .iteration_limit = std::nullopt, .records = !call[dump].empty()};
  if (options.records) {
    require_folder(call[dump], {}, {});
  }
  if (call[option::quick]) {
    options.iteration_limit = quick_iterations;
  }
  double total = 0.0;
  for (const Scene& scene : scenes) {
    total += site_updates(scene, options.iteration_limit);
  }
  progress.set_total(total);

  json rows = json::array();
  std::vector<Comparison> all;
  std::set<std::string> dumped;
  for (const Scene& scene : scenes) {
    std::string dumps;
    std::vector<Comparison> comparisons =
        verify(scene, *backends.front(), std::span(backends).subspan(1), options, progress);
    progress.clear();
    find_lost(comparisons, all);
    for (Comparison& comparison : comparisons) {
      const auto* const shared = dynamic_cast<const RankBackend*>(
          *std::ranges::find(backends, comparison.backend, &Backend::name)); // null: in one process
      if (shared != nullptr && shared->has_bits_of_scalar()) {
        excuse_nothing(comparison);
      }
      json& row = rows.emplace_back(row_of(call, scene, comparison, shared));
      dumps += dump_step(call, comparison, row, dumped);
      comparison.step = nullptr; // it may be large
      all.push_back(comparison);
    }
    print_scene(scene, comparisons, call);
    fmt::print("{}", dumps);
    call.keep(rows);
  }
  fmt::print("\nAll scenes, all modes\n{}",
             table_text(rows_by_backend(all),
                        "backend|tier:tier reached|comparisons|exact:of them exact|sites:sites compared|"
                        "differing|certified|uncertified"));
  if (options.records && dumped.empty()) {
    fmt::print("\n--dump: no bits differ in a step that could be kept, so nothing was written\n");
  }
  print_findings(std::span(backends).subspan(1), all, call.session());
  const auto count = [&](Verdict verdict) { return std::ranges::count(all, verdict, &Comparison::verdict); };
  const Tier required = call[required_tier] == "bitwise" ? Tier::bitwise : Tier::certified;
  const bool is_good = std::ranges::all_of(all, [&](const Comparison& comparison) {
    return comparison.verdict == Verdict::skipped || comparison.tier >= required;
  });
  fmt::print("\n{} comparisons with {} agree to the bit, {} are certified, {} disagree, {} are mistrusted, "
             "{} were skipped\n",
             count(Verdict::agree), backends.front()->name(), count(Verdict::certified),
             count(Verdict::disagree), count(Verdict::mistrusted), count(Verdict::skipped));
  if (required == Tier::bitwise && count(Verdict::certified) > 0) {
    fmt::print("--require-tier bitwise: certified is not enough\n");
  }
  if (call.speaks()) {
    report::write_junit(call[junit], rows);
  }
  call.write(std::move(rows));
  return ended(call, is_good, what_is_missing(call, backends, all));
}

/// Without those that several ranks cannot compute, which it names, and where nobody chose with what sleeps
/// on so many ranks.
std::vector<Scene> scenes_for_ranks(const Call& call, int ranks) {
  std::vector<Scene> scenes = scenes_to_verify(call);
  if (are_all(call)) {
    scenes.push_back(sleeping_pieces(ranks));
  }
  require_same_scenes(call, scenes);
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
int verify_on_ranks(Call& call, Ranks& ranks) {
  call.schedule.takes_boxes = true;
  if (!call[reference].empty()) {
    throw InputError("verify --reference runs in one process: leave out mpirun");
  }
  if (!call[dump].empty()) {
    throw InputError("verify --dump runs in one process: leave out mpirun");
  }
  const auto registry = make_backends();
  std::vector<std::string> names = call[option::backends];
  for (std::size_t i = 0; i < registry.size() && call[option::backends].empty(); ++i) {
    names.emplace_back(registry[i]->name());
  }
  const SessionOptions asked = call.session();
  call[option::device].clear(); // a rank's own is taken already
  call[option::threads] = 0;
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
  return verify_scenes(call, backends, scenes_for_ranks(call, ranks.size()));
}

int run_verify(Call& call) {
  const Gates gates(call);
  if (call.ranks != nullptr) {
    return gates.judge(verify_on_ranks(call, *call.ranks), call);
  }
  const auto registry = make_backends();
  if (!call[reference].empty()) {
    (void)find_backend(registry, call[reference]); // "none" is none
  }
  const std::vector<const Backend*> backends = choose_backends(call, registry, call[reference]);
  if (backends.size() == 1) {
    throw InputError(fmt::format("no backend is left to compare with {}; name one with --backends",
                                 backends.front()->name()));
  }
  call.schedule.takes_boxes = true;
  return gates.judge(verify_scenes(call, backends, scenes_to_verify(call)), call);
}

} // namespace

void add_verify(CLI::App& program, Call& call) {
  add_command(
      program, call, "verify", run_verify,
      "Compare every backend with scalar, bit for bit.\n"
      "Run every backend beside scalar and compare all sites after every iteration, bit for bit.\n"
      "resync: each iteration starts from scalar's field. free: each backend runs on its own.\n"
      "active: free, leaving out what cannot change. pyramid: all levels in one call, the last field.\n"
      "A site that differs is certified where a bound of rounding, derived from the operations at\n"
      "that site, explains the difference; never on a scene whose arithmetic is exact.\n"
      "Where bits differ, the rewrite of the arithmetic that makes them is named, with its line;\n"
      "--dump DIR writes that step, with its data, as a small program for those who made the driver.\n"
      "Without scenes: all of them, the other methods, and three sizes that meet the backends' tiles.\n"
      "mpirun -n R hdmbench verify: every backend, or mixture as openmp+vulkan-compute, on 1 ... R ranks.\n"
      "Exit status 1 if a backend disagrees or a scene could not have shown it.",
      {comparison_options(), option::law, required_tier, junit, reference, dump, gate_options(true)},
      {"--methods excludes --method"});
}

} // namespace hdmbench::commands
