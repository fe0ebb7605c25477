#include "backends/shared/stopwatch.hpp"
#include "harness/check/compare.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/run_conditions.hpp"
#include "harness/cli/run_files.hpp"
#include "harness/cli/run_points.hpp"
#include "harness/cli/run_spread.hpp"
#include "harness/cli/warp.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/measure/memory_use.hpp"
#include "harness/ranks/message_passing.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/request.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/level.hpp"
#include "reference/finite_elements.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <ranges>
#include <span>

namespace hdmbench::commands {

namespace {

const Option<std::string> scene_or_labels("scene",
                                          "Scene by name or TOML file, or with --tissues an image of labels",
                                          Content::labels);
const Option<std::string>
    accuracy("--accuracy", "Distance from finite elements that is good enough, RMS, as 0.2px or 0.1mm: with "
                           "the elastic energy, and levels and steps that follow from the scene; exit status "
                           "1 where the estimate is above it, or cannot be trusted");
const Option<std::string>
    within("--within",
           "The time there is, as 10ms or 2s: the best field of the elastic energy and its error");
const Option<OutputFile>
    transform("--transform",
              "Also the displacement that leads back, with which ITK, ANTs, 3D Slicer and hdmbench warp move "
              "pictures as the tissue moves: .h5 (ITK), .nrrd, .mha or .nii.gz",
              Content::transform);
const Option<std::vector<std::filesystem::path>>
    moving("--warp", "Also these pictures, moved with the file of --transform, as hdmbench warp moves them",
           Content::image);
const Option<bool> no_pictures("--no-pictures", "Write the displacement alone");
const Option<bool> explain("--explain", "Print the plan, step by step, and why");
const Option<std::size_t>
    sites_per_rank("--sites-per-rank",
                   "With mpirun: a level goes to as many ranks as get so many sites each, 0: 16384, of the "
                   "elastic energy 4096; --backend is then one for all, or as openmp+vulkan-compute each "
                   "rank's in turn, and --device may be by-rank");
const Option<int> halo("--halo",
                       "With mpirun: sites that a rank computes beyond its own, a multiple of 4, on every "
                       "level; 0: an eighth of the shortest piece, 4 ... 64. Of the elastic energy those of "
                       "the coarsest level that is cut, even; 0: 4. The bits are the same",
                       0, CLI::Range(0, 1024));

bool asks(const Call& call) {
  return !call[accuracy].empty() || !call[within].empty();
}

/// What is asked for of a scene whose pixels have sides of `spacing` millimetres. Throws InputError.
Request request_of(const Call& call, double spacing) {
  return parse_request(call[accuracy], call[within], spacing);
}

/// `counted`: whether solution.levels have counts of changes.
void print_levels(const Solution& solution, bool counted) {
  json rows = json::array();
  bool repeated = false;
  for (const LevelResult& level : solution.levels) {
    repeated = repeated || level.repeated;
    rows.push_back(
        with_size({{"level", level.level},
                   {"iterations", fmt::format("{}{}", level.iterations, level.repeated ? " *" : "")},
                   {"moving", counted ? json(level.changed) : json()}},
                  level.extent));
  }
  fmt::print("{}{}", table_text(rows, "level|size|iterations|moving:sites still moving"),
             repeated ? "  * acceleration diverged, computed again without\n" : "");
}

/// Returns the mean over sites of the energy that the displacement minimises; none for laws of large strains,
/// which have their forces alone.
std::optional<double> mean_energy_of(const Scene& scene, const VectorField& displacement) {
  if (has_laws(scene.full)) {
    return std::nullopt;
  }
  if (!scene.energy->is_of_cells()) {
    return mean_energy(scene.full, displacement);
  }
  const double twice = elastic_energy(elastic_problem(scene.full),
                                      ElementRule::of(scene.extent(), scene.elastic), displacement);
  return twice / 2.0 / static_cast<double>(scene.extent().sites());
}

/// How ranks share the scene out. Throws InputError where they cannot.
Sharing sharing_of(const Scene& scene, const Call& call) {
  const bool of_cells = scene.energy->is_of_cells();
  const int granule = of_cells ? 2 : 4;
  if (call[halo] % granule != 0) {
    throw InputError(fmt::format("--halo {}: a multiple of {}{}, or 0", call[halo], granule,
                                 of_cells ? fmt::format(" for the {} energy", scene.energy->name) : ""));
  }
  if (scene.full.update == Update::sequential) {
    throw InputError("sequential, each of whose sweeps crosses the image site by site, runs on one rank");
  }
  return {.ranks = call.ranks->size(),
          .pieces = call.ranks->size(),
          .fewest_sites = call[sites_per_rank],
          .halo = call[halo]};
}

/// The scene, which a request solves with the energy that comes near to finite elements.
Scene load_for(Call& call) {
  call.schedule.takes_boxes = true;
  return load_to_solve(call.schedule, asks(call), [&] { return scene_of(call); });
}

/// A request is a method of its own, so what belongs to another one has no meaning beside it. Throws
/// InputError.
void require_meaning(const Call& call) {
  const CLI::App& command = *call.command;
  (void)request_of(call, 1.0);
  if (const auto* const energy = call.schedule.energy; asks(call) && energy != nullptr) {
    require_near_finite_elements(*energy, fmt::format("--energy {}", energy->name));
  }
  if (launched_together() == 0) {
    refuse_idle(command, {"--sites-per-rank", "--halo"},
                "ranks are several processes, mpirun -n 4 hdmbench run ..., and this one is alone");
  }
  if (call.ranks != nullptr) {
    refuse_idle(command, {"--accuracy", "--within"}, "that runs in one process, without mpirun");
  }
  if (asks(call)) {
    refuse_idle(
        command,
        schedule_names(command, {"--energy", "--penalty", "--prior-weight", "--alignment", "--poisson"}),
        "--accuracy and --within choose method, levels and iterations themselves");
  } else {
    refuse_idle(command, {"--explain"}, "it explains a plan, which --accuracy or --within ask for");
  }
}

/// What each rank did, on the first one; nothing on the others. Collective.
json rows_of_ranks(const Call& call, const std::vector<std::unique_ptr<Backend>>& registry,
                   const RankBackend& backend, const PeakMemory& memory, Ranks& ranks) {
  const Traffic traffic = ranks.traffic();
  const json own{{"machine", machine_name()},
                 {"backend", backend_of_rank(registry, call[option::backend], ranks.rank()).name()},
                 {"device", backend.device({}).name},
                 {"threads", backend.threads({})}, // of its own, 0: its driver decides
                 {"messages", traffic.messages},
                 {"bytes", traffic.bytes},
                 {"peak_memory", memory.bytes().value_or(0)}}; // 0: the system does not tell
  return gather_rows(json::array({own}), ranks);
}

/// Null is what is not known.
json plan_row(const Scene& scene, const Request& request, const Plan& plan) {
  json row{{"scene", scene.name},
           {"met", plan.met},
           {"fine_sweep_equivalents", fine_sweep_equivalents(plan)},
           {"steps", json::array()},
           {"asked_px", request.accuracy},
           {"asked_seconds", request.seconds},
           {"linear_distance_px", plan.linear_distance},
           {"estimated_px", plan.solution.estimated_error}};
  for (const PlanStep& step : plan.steps) {
    row["steps"].push_back(with_size({{"action", step.action},
                                      {"reason", step.reason},
                                      {"moved", step.moved},
                                      {"seconds", step.seconds},
                                      {"expected_error", step.expected_error}},
                                     step.extent));
  }
  return row;
}

/// A scene that was solved, by a plan or by its own method.
struct Solved {
  const Scene& scene;
  const Request& request;
  const std::optional<Plan>& plan;
  const Solution& solution;
  std::string backend; ///< of ranks all of them
  std::string name;    ///< of the backend for people: "openmp on 2 ranks"
  std::string device;
  std::string absurd; ///< why there is no displacement; empty: there is one
  Warnings warnings;
  std::vector<std::optional<double>> left_out; ///< misses_left_out()
  const SpreadOfRun& how_sure;

  [[nodiscard]] std::string method() const { return plan ? "as needed" : method_name(scene); }
  [[nodiscard]] bool is_volume() const { return scene.extent().axes() == 3; }
  [[nodiscard]] const char* unit() const { return is_volume() ? "voxels" : "px"; }
};

json row_of(const Solved& solved, json phases) {
  const auto& [scene, request, plan, solution, backend, name, device, absurd, warnings, left_out, how_sure] =
      solved;
  json row = with_size({{"scene", scene.name},
                        {"title", scene.title},
                        {"backend", backend},
                        {"device", device},
                        {"method", solved.method()},
                        {"energy", scene.energy->name},
                        {"seconds", solution.timings.total()},
                        {"levels", solution.levels.size()},
                        {"iterations", total_iterations(solution.levels)},
                        {"mean_energy", absurd.empty() ? mean_energy_of(scene, solution.displacement)
                                                       : std::numeric_limits<double>::quiet_NaN()},
                        {"least_volume", solution.least_volume},
                        {"part", solution.part ? json(solution.part->text("x")) : json(nullptr)},
                        {"largest_displacement", largest_magnitude(solution.displacement, tissue_of(scene))},
                        {"spacing", scene.spacing},
                        {"placement", scene.placement},
                        {"warnings", warnings},
                        {"estimated_px", solution.estimated_error},
                        {"field", ""},
                        {"phases", std::move(phases)}},
                       scene.extent());
  if (plan) {
    row["plan"] = plan_row(scene, request, *plan);
  }
  return row;
}

/// Prints how the scene was solved: the plan, with its steps where they are to be explained, or the levels.
void print_way(const Solved& solved, const json& row, bool explained) {
  const Scene& scene = solved.scene;
  const auto sides = std::span(scene.full.sides).first(scene.extent().axes());
  std::string side = fmt::format("{:.4g}", scene.spacing);
  if (scene.full.sides != Level{}.sides) {
    side = fmt::format(
        "{:.4g}",
        fmt::join(sides | std::views::transform([&](double one) { return one * scene.spacing; }), " x "));
  }
  fmt::print("{}\n{} {} of {} mm, {} on {} ({})\n\n", scene.title, scene.extent().text(),
             solved.is_volume() ? "voxels" : "pixels", side, solved.method(), solved.name, solved.device);
  if (!solved.plan) {
    print_levels(solved.solution, is_inspected(scene.extent()) && !scene.energy->is_of_cells());
    return;
  }
  if (explained) {
    fmt::print("{}\n",
               table_text(row["plan"]["steps"],
                          "size|action:step|moved:moved px|expected_error:error px|seconds|reason:why"));
  }
  fmt::print("  {}{}; {:.3g} sweeps over the full resolution in all\n", solved.plan->outcome,
             scene.oblong && !has_equal_sides(*scene.oblong)
                 ? fmt::format(" on the resampled {}", solved.is_volume() ? "cubes" : "squares")
                 : "",
             fine_sweep_equivalents(*solved.plan));
  if (const std::optional<double>& distance = solved.plan->linear_distance) {
    fmt::print("  the linear law stands: the law of large strains is about {:.2g} {} from it\n", *distance,
               solved.unit());
  }
}

/// Prints what came out, and what speaks against it.
void print_result(const Call& call, const Solved& solved, json& row) {
  const Solution& solution = solved.solution;
  fmt::print("\n  {}, largest displacement {:.4g} {}, {} iterations in {}\n",
             solution.least_volume
                 ? fmt::format("least {} of a cell {:.3g} of what it was",
                               solved.is_volume() ? "volume" : "area", *solution.least_volume)
                 : fmt::format("mean energy {:.6g}", row["mean_energy"].get<double>()),
             row["largest_displacement"].get<double>(), solved.unit(), row["iterations"].get<std::int64_t>(),
             duration_text(solution.timings.total()));
  if (solution.part) {
    fmt::print("  conditions hold all but {} {}, and these alone were solved\n", solution.part->text(),
               solved.is_volume() ? "voxels" : "pixels");
  }
  if (solution.estimated_error && !solved.plan) {
    fmt::print("  estimated distance from finite elements {:.2g} {}\n", *solution.estimated_error,
               solved.unit());
  }
  report_conditions(solved.scene, solution.displacement, row);
  report_points(solved.scene, solution.displacement, solved.left_out, row);
  report_spread(call, solved.scene, solved.how_sure, row);
  if (!solved.absurd.empty()) {
    fmt::print("  {}\n", no_result_text(solved.scene, solved.absurd));
  }
  fmt::print("\n{}\n", is_inspected(solved.scene.extent())
                           ? warnings_text(solved.warnings)
                           : "  Not diagnosed, and no pictures: beyond 4096 x 4096 sites that takes more "
                             "time and memory than the solution.\n");
}

/// Throws InputError where files cannot be written: those of `names`, and what --warp and --transform ask
/// for.
void require_files(const Call& call, const Scene& scene, std::vector<std::string> names) {
  std::vector<std::filesystem::path> read = files_of_scene(call[option::scene]);
  std::ranges::copy(call[moving], std::back_inserter(read));
  if (!call[moving].empty() && call[transform].empty()) {
    throw InputError("--warp moves pictures with the file of --transform: give both");
  }
  for (const std::string& moved : moved_names(call[moving], call[option::format])) {
    if (std::ranges::find(names, moved) != names.end()) {
      throw InputError(fmt::format("a picture of --warp would become {}, which run writes anyway: give its "
                                   "file another name, or call hdmbench warp",
                                   moved));
    }
    names.push_back(moved);
  }
  require_folder(call[option::output], names, read);
  if (call[transform].empty()) {
    return;
  }
  require_displacement_name(call[transform], scene.extent());
  require_own_name(call[transform], "--transform", call[option::output], names);
}

/// Returns file_names(). Throws InputError where what is asked for cannot be written, or told, before
/// anything is solved.
std::vector<std::string> files_of(const Call& call, const Scene& scene, const SpreadOfRun& how_sure) {
  if (call[option::format] == "nii.gz" && scene.extent().axes() == 2) {
    throw InputError("--format nii.gz is for volumes: programs read a NIfTI file of one slice without its "
                     "place in space; give nrrd or mha");
  }
  require_points(call, scene);
  const Pictures drawn = call[no_pictures] ? Pictures::none
                         : how_sure.asked  ? Pictures::with_deviation
                                           : Pictures::usual;
  std::vector<std::string> names = file_names(scene, call[option::format], drawn);
  require_spread(call, scene, how_sure, names);
  if (have_images()) {
    let_first_check(call.ranks, [&] { require_files(call, scene, names); });
  }
  return names;
}

/// Prints what the user waited for.
void print_phases(const json& row) {
  fmt::print("\n{}",
             table_text(json::array({row["phases"]}),
                        "reading_seconds:reading|unloading_seconds:unloading|"
                        "solution_seconds:solution|setup_seconds:its set-up|"
                        "left_out_seconds:left out|uncertainty_seconds:how sure|"
                        "diagnosis_seconds:diagnosis|pictures_seconds:pictures|transform_seconds:transform|"
                        "writing_seconds:writing|command_seconds:in all"));
}

/// Waits for the files, if there are to be any, and ends the row.
void finish_files(const Call& call, std::optional<FilesOfRun>& written, const Clock& clock,
                  Progress& progress, json& row) {
  if (written) {
    written->finish(call[option::json], row);
    const std::vector<std::filesystem::path>& to_move = call[moving];
    const std::vector<std::string> names = moved_names(to_move, call[option::format]);
    for (std::size_t i = 0; have_images() && i < to_move.size(); ++i) {
      fmt::print("  {}\n",
                 move_picture(call[option::output] / names[i], to_move[i], call[transform], false, progress));
      row["moved"].push_back(beside(call[option::json], call[option::output], names[i]));
    }
  } else {
    fmt::print("  No files are written: there is no displacement.\n");
  }
  row["phases"]["command_seconds"] = clock.seconds();
  print_phases(row);
}

/// Prints all that the row of a run says, and adds to it what the ranks did, where there are several.
void print_run(const Call& call, const Solved& solved, const json& by_rank, json& row) {
  print_way(solved, row, call[explain]);
  if (call.ranks != nullptr) {
    row.update({{"ranks", call.ranks->size()}, {"by_rank", by_rank}});
    fmt::print("\n{}", table_text(by_rank, "machine|backend|device|threads|messages|bytes:bytes sent|"
                                           "peak_memory:bytes at most"));
  }
  print_result(call, solved, row);
}

/// Returns the scene of all ranks, and adds to the phases what it took since the clock began.
Scene timed_scene(Call& call, const Clock& clock, json& phases) {
  Scene scene = load_for(call);
  phases["reading_seconds"] = clock.seconds() - (scene.resected ? scene.resected->seconds : 0.0);
  if (scene.resected) {
    phases["unloading_seconds"] = scene.resected->seconds;
  }
  require_same_scenes(call, {&scene, 1});
  return scene;
}

/// Returns all ranks as one backend; null without ranks. Takes from `session` the device, which each rank has
/// taken for itself.
std::unique_ptr<RankBackend> backend_of_ranks(const Call& call,
                                              const std::vector<std::unique_ptr<Backend>>& registry,
                                              const Scene& scene, SessionOptions& session) {
  if (call.ranks == nullptr) {
    return nullptr;
  }
  auto shared = std::make_unique<RankBackend>(*call.ranks, registry, call[option::backend], session,
                                              sharing_of(scene, call));
  session.device.clear();
  return shared;
}

/// solve_request() that adds to the phases what it took.
Answer timed_answer(Scene& scene, const Request& request, const Backend& backend,
                    const SessionOptions& session, Progress& progress, json& phases) {
  const Clock solving;
  Answer answer = solve_request(scene, request, backend, session, progress);
  const Timings& timings = answer.solution().timings;
  phases["solution_seconds"] = solving.seconds();
  phases["setup_seconds"] = timings.projection + timings.upload;
  return answer;
}

int run_scene(Call& call) {
  const Clock clock;
  require_meaning(call);
  const PeakMemory memory;
  Progress progress(call.speaks());
  progress.describe(fmt::format("prepare {}", call[option::scene]));
  SpreadOfRun how_sure = asked_spread(call);
  json phases;
  Scene scene = timed_scene(call, clock, phases);
  const Request request = request_of(call, scene.spacing);
  const auto registry = make_backends();
  SessionOptions session = call.session();
  const std::unique_ptr<RankBackend> shared = backend_of_ranks(call, registry, scene, session);
  const Backend& backend = shared ? *shared : choose_backend(call, registry, scene);
  const Device device = backend.device(session);
  const std::vector<std::string> files = files_of(call, scene, how_sure);
  const Answer answer = timed_answer(scene, request, backend, session, progress, phases);
  const Solution& solution = answer.solution();
  const auto left_out = misses_left_out(
      call, scene.points.size(),
      [&](Scene& of) {
        return solve_request(of, request, backend, session, progress).solution().displacement;
      },
      phases);
  std::string absurd = why_absurd(scene, solution);
  if (absurd.empty()) {
    draw_spread(scene, solution.displacement, backend, session, progress, how_sure, phases);
  }
  const json by_rank = shared ? rows_of_ranks(call, registry, *shared, memory, *call.ranks) : json();
  if (!call.speaks()) { // all ranks have the same field
    return success;
  }
  const Clock diagnosing;
  std::optional<FilesOfRun> written;
  if (absurd.empty()) {
    written.emplace(call[option::output], files, call[transform], scene, solution.displacement,
                    how_sure.found ? &how_sure.found->deviation : nullptr);
  }
  progress.describe(fmt::format("diagnose and write {}", scene.name));
  const Solved solved{scene,
                      request,
                      answer.plan,
                      solution,
                      shared ? shared->backends() : std::string(backend.name()),
                      std::string(backend.name()),
                      device.name,
                      std::move(absurd),
                      diagnose(scene, solution, answer.plan),
                      left_out,
                      how_sure};
  phases["diagnosis_seconds"] = diagnosing.seconds();
  json row = row_of(solved, std::move(phases));
  progress.clear();
  print_run(call, solved, by_rank, row);
  finish_files(call, written, clock, progress, row);
  call.write(json::array({without_nulls(row)}));
  const bool is_sound = solved.absurd.empty() && doubt_about(solution).empty();
  return is_sound && (!answer.plan || answer.plan->met) ? success : disagreement;
}

} // namespace

void add_run(CLI::App& program, Call& call) {
  add_command(
      program, call, "run", run_scene,
      "Solve one scene, write displacement and pictures.\n"
      "Solve one scene; write the displacement in millimetres, and the picture before and after, the\n"
      "deformed grid and the displacement's magnitude and change of area or volume as PNG; say what speaks\n"
      "against the result.",
      {scene_or_labels, option::size, option::tissues, option::law, option::points, leave_one_out,
       schedule_options(true), backend_options(), option::output, option::format, transform, moving,
       no_pictures, option::json, spread_options().under("How sure is it?"),
       Options{accuracy, within, explain}.under("No more than the scene needs"),
       Options{sites_per_rank, halo}.under("Several processes (mpirun -n 4 hdmbench run ...)")},
      {"scene is required", "--uncertain-moduli needs --uncertainty", "--spread needs --uncertainty",
       "--mean needs --uncertainty"});
}

} // namespace hdmbench::commands
