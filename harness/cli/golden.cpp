#include "harness/check/golden.hpp"
#include "harness/cli/arguments.hpp"

#include <fmt/ranges.h>

namespace hdmbench::commands {

namespace {

const Option<OutputFile> to_write("--write",
                                  "Write the hashes to this file, if all backends agree; "
                                  "harness/check/golden.json is what the next build compares with");
const Option<std::filesystem::path>
    to_compare("--golden",
               "Compare with the hashes of this file, which --write wrote, in place of the committed ones");

/// Scenes as the user's own files have them, and not the shipped ones with few iterations.
bool has_own_scenes(const Call& call) {
  const std::vector<Case> known = golden_cases();
  return !std::ranges::all_of(call[option::scenes],
                              [&](const std::string& scene) { return contains(known, scene, &Case::scene); });
}

json outcome_text(const GoldenOutcome& outcome) {
  switch (outcome.verdict) {
  case Verdict::agree:
    return "✓";
  case Verdict::mistrusted:
    return "as scalar";
  case Verdict::skipped:
    return nullptr;
  default:
    return outcome.first_difference ? fmt::format("✗ level {}", *outcome.first_difference) : "✗";
  }
}

/// A row a case with the hash of scalar's finest level, a column a backend.
void print_table(const std::vector<GoldenResult>& results, std::span<const GoldenSolver> solvers) {
  std::string columns = "scene|size|method|hash|inputs";
  for (const GoldenSolver& solver : solvers) {
    columns += fmt::format("|{}", solver.backend().name());
  }
  json rows = json::array();
  for (const GoldenResult& result : results) {
    json& row = rows.emplace_back(with_size(
        {{"scene", result.problem.scene}, {"method", result.problem.method}}, *result.problem.size));
    const std::vector<GoldenLevel>& levels = result.outcomes.front().levels;
    row["hash"] = levels.empty() ? "-" : fmt::format("{:016x}", levels.back().hash);
    row["inputs"] = result.inputs_reason.empty() ? "✓" : "✗";
    for (const GoldenOutcome& outcome : result.outcomes) {
      row[outcome.backend] = outcome_text(outcome);
    }
  }
  fmt::print("{}", table_text(rows, columns));
}

/// What the table leaves open, each once.
void print_remarks(const std::vector<GoldenResult>& results, std::span<const GoldenSolver> solvers,
                   const Call& call) {
  for (const GoldenSolver& solver : solvers) {
    if (!solver.absence().empty()) {
      fmt::print("  {}: skipped: {}\n", solver.backend().name(), solver.absence());
    }
  }
  for (const GoldenResult& result : results) {
    if (result.known && !result.inputs_reason.empty()) {
      fmt::print("  {}: the inputs are not golden: {}\n", result.problem.name(), result.inputs_reason);
    }
    for (const GoldenOutcome& outcome : result.outcomes) {
      if (outcome.verdict == Verdict::disagree) {
        fmt::print("  {}, {}: {}\n    repeat: hdmbench golden {} --backends {}{}\n", result.problem.name(),
                   outcome.backend, outcome.reason, result.problem.scene, outcome.backend,
                   session_words(call.session()));
      }
    }
  }
  const auto unknown = std::ranges::count(results, false, &GoldenResult::known);
  if (unknown > 0) {
    fmt::print("  {} cases are new, and compared with scalar only: hdmbench golden {}\n", unknown,
               has_own_scenes(call) ? "SCENES --write FILE, then SCENES --golden FILE"
                                    : "--write harness/check/golden.json, then build");
  }
}

/// The user's own scenes, of which no two may be the same case. Throws InputError.
std::vector<Scene> load_own_scenes(const Call& call) {
  std::vector<Scene> scenes = load_scenes(call, {});
  for (auto scene = scenes.begin(); scene != scenes.end(); ++scene) {
    const Case problem = case_of(*scene);
    if (std::any_of(scenes.begin(), scene, [&](const Scene& other) { return case_of(other) == problem; })) {
      throw InputError(fmt::format("two scenes are {}; give one of them another name", problem.name()));
    }
  }
  return scenes;
}

/// The cases of the scenes that were asked for. Throws InputError for a name that is no shipped scene; where
/// files are not on this machine, MissingFile for one that was named or that a golden file would lose, else
/// the scene is left out, which is printed.
std::vector<Scene> load_golden_scenes(const Call& call) {
  const std::vector<Case> cases = golden_cases();
  for (const std::string& name : call[option::scenes]) {
    if (!contains(cases, name, &Case::scene)) {
      throw InputError(
          fmt::format("there are golden hashes of the shipped scenes only, which are {}; not of \"{}\". Of "
                      "scenes of your own, --write FILE keeps them and --golden FILE compares with them",
                      fmt::join(shipped_scenes(), ", "), name));
    }
  }
  std::vector<Scene> scenes;
  for (const Case& problem : cases) {
    const bool is_named = contains(call[option::scenes], problem.scene);
    if (!is_named && !call[option::scenes].empty()) {
      continue;
    }
    if (auto scene = load_unless_missing(problem.name(), is_named || !call[to_write].empty(),
                                         [&] { return load_case(problem); })) {
      scenes.push_back(std::move(*scene));
    }
  }
  return scenes;
}

/// A new file, of what all backends agree on.
int write_golden(const std::vector<GoldenResult>& results, const std::vector<GoldenEntry>& before,
                 const std::filesystem::path& file) {
  std::vector<GoldenEntry> entries;
  int changed = 0;
  for (const GoldenResult& result : results) {
    if (const std::string doubt = doubt_about(result); !doubt.empty()) {
      fmt::print("{} is not written: {}: {}\n", file.string(), result.problem.name(), doubt);
      return disagreement;
    }
    entries.push_back({result.problem, result.inputs, result.outcomes.front().levels});
    const bool same = result.inputs_reason.empty() && result.outcomes.front().verdict == Verdict::agree;
    changed += same ? 0 : 1;
  }
  write_text(file, golden_text(entries));
  fmt::print("{}: {} cases, of which {} changed or are new; before there were {}\n", file.string(),
             entries.size(), changed, before.size());
  return success;
}

int run_golden(Call& call) {
  const Gates gates(call);
  const auto registry = make_backends();
  std::vector<GoldenSolver> solvers;
  for (const Backend* backend : choose_backends(call, registry)) {
    solvers.emplace_back(*backend, call.session());
  }
  const bool own_scenes = has_own_scenes(call) && !(call[to_write].empty() && call[to_compare].empty());
  if (!own_scenes && !call[option::scenes].empty() && !call[to_write].empty()) {
    throw InputError(fmt::format("--write {}: leave out the scenes, because the file has all shipped ones",
                                 call[to_write].string()));
  }
  call.schedule.takes_boxes = true;
  const std::vector<Scene> scenes = own_scenes ? load_own_scenes(call) : load_golden_scenes(call);
  std::vector<GoldenEntry> given;
  if (!call[to_compare].empty()) {
    given = read_golden(read_file(call[to_compare]), call[to_compare].string());
  }
  const std::vector<GoldenEntry>& golden =
      own_scenes || !call[to_compare].empty() ? given : committed_golden();
  Progress progress;
  double total = 0.0;
  for (const Scene& scene : scenes) {
    total += site_updates(scene) * static_cast<double>(solvers.size());
  }
  progress.set_total(total);
  std::vector<GoldenResult> results;
  json rows = json::array();
  std::array<int, verdict_names.size()> count{};
  for (const Scene& scene : scenes) {
    results.push_back(check_golden(scene, solvers, find_golden(golden, case_of(scene)), progress));
    for (const GoldenOutcome& outcome : results.back().outcomes) {
      rows.push_back(golden_row(results.back(), outcome));
      ++count.at(static_cast<std::size_t>(outcome.verdict));
    }
    call.keep(rows);
  }
  progress.clear();
  fmt::print("Displacements of all levels, hashed, against those {}; the last one also made in one piece:\n",
             call[to_compare].empty() ? "committed" : "of " + call[to_compare].string());
  print_table(results, solvers);
  print_remarks(results, solvers, call);
  const auto [agree, certified, skipped, mistrusted, disagree] = count;
  fmt::print("\n{} solutions are golden, {} are not, {} have nothing to be compared with, {} skipped\n",
             agree, disagree, mistrusted, skipped);
  call.write(std::move(rows));
  const char* const missing =
      agree + disagree + mistrusted > 0 ? "" : "nothing was compared, so nothing is golden";
  const int status = !call[to_write].empty() ? write_golden(results, golden, call[to_write])
                                             : ended(call, disagree + mistrusted == 0, missing);
  return gates.judge(status, call);
}

} // namespace

void add_golden(CLI::App& program, Call& call) {
  add_command(
      program, call, "golden", run_golden,
      "Compare hashes of the fields with those committed.\n"
      "Solve the shipped scenes at fixed sizes on every backend and compare a hash of the field of every\n"
      "level with those committed: machines, compilers and versions are to give the same bits, not only\n"
      "backends. Scenes of your own: SCENE.toml --write FILE keeps their hashes, SCENE.toml --golden FILE\n"
      "compares with them.\n"
      "Exit status 1 if a hash differs, or there is none to compare with.",
      {Options(option::scenes,
               "Shipped scenes by name (none: all); with --golden or --write your own, by file"),
       backends_options(), gate_options(), to_compare, to_write, option::json},
      {"--write excludes --backends"});
}

} // namespace hdmbench::commands
