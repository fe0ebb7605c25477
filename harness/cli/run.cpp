#include "harness/check/compare.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/run_files.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/measure/memory_use.hpp"
#include "harness/ranks/message_passing.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/planner.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/level.hpp"
#include "reference/finite_elements.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>

namespace hdmbench::commands {

namespace {

struct Arguments {
  SceneArguments scene;
  std::filesystem::path output = "hdmbench-output";
  std::string format = "nrrd"; ///< extension of the field's file
  std::string accuracy;        ///< "0.2px" or "0.1mm"; empty: not asked for
  std::string within;          ///< "10ms"; empty: not asked for
  bool explain = false;
  std::size_t sites_per_rank = 0; ///< of Sharing
  int halo = 0;                   ///< the same

  [[nodiscard]] bool asks() const { return !accuracy.empty() || !within.empty(); }
  /// Of a scene whose pixels have sides of `spacing` millimetres. Throws InputError.
  [[nodiscard]] Request request(double spacing) const {
    Request wanted;
    if (!accuracy.empty()) {
      wanted.accuracy = parse_pixels(accuracy, spacing);
    }
    if (!within.empty()) {
      wanted.seconds = parse_seconds(within);
    }
    return wanted;
  }
};

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

/// Of the energy that the displacement minimises, over sites.
double mean_energy_of(const Scene& scene, const VectorField& displacement) {
  if (!scene.energy->is_of_cells()) {
    return mean_energy(scene.full, displacement);
  }
  const double twice =
      elastic_energy(elastic_problem(scene.full), ElementRule::of(scene.extent(), scene.poisson),
                     ReferenceField(displacement));
  return twice / 2.0 / static_cast<double>(scene.extent().sites());
}

/// How ranks share the scene out. Throws InputError where they cannot.
Sharing sharing_of(const Scene& scene, const Arguments& arguments, const Ranks& ranks) {
  const bool of_cells = scene.energy->is_of_cells();
  const int granule = of_cells ? 2 : 4;
  if (arguments.halo % granule != 0) {
    throw InputError(fmt::format("--halo {}: a multiple of {}{}, or 0", arguments.halo, granule,
                                 of_cells ? fmt::format(" for the {} energy", scene.energy->name) : ""));
  }
  if (scene.full.update == Update::sequential) {
    throw InputError("sequential, each of whose sweeps crosses the image site by site, runs on one rank");
  }
  return {.ranks = ranks.size(),
          .pieces = ranks.size(),
          .fewest_sites = arguments.sites_per_rank,
          .halo = arguments.halo};
}

/// Throws InputError for a request with an energy, which `says` asks for, that does not come near to finite
/// elements.
void require_near_finite_elements(const RegisteredEnergy& energy, std::string_view says) {
  if (energy.near == ReferenceSolution::finite_elements) {
    return;
  }
  throw InputError(fmt::format(
      "--accuracy and --within ask for a distance from finite elements, which the elastic energy comes near "
      "and {0}'s does not, however long it is solved; {1} asks for {0}'s: give --energy "
      "elastic, or --method and --iterations in place of --accuracy and --within",
      energy.summary, says));
}

/// The scene, which a request solves with the energy that comes near to finite elements.
Scene load_for(const Arguments& arguments) {
  if (!arguments.asks() || arguments.scene.schedule.energy != nullptr) {
    return arguments.scene.load();
  }
  SceneArguments asking = arguments.scene;
  asking.schedule.energy = &energy_near(ReferenceSolution::finite_elements);
  Scene scene = asking.load();
  if (scene.stated_energy != nullptr) {
    require_near_finite_elements(*scene.stated_energy, scene.source);
  }
  return scene;
}

/// Throws InputError for a body that nothing holds, pulls or has moved: any displacement would do.
void require_held(const Scene& scene) {
  const auto is_free = [](float confidence) { return confidence == 0.0F; };
  if (!scene.start && std::ranges::all_of(scene.full.confidence.planes, [&](const auto& plane) {
        return std::ranges::all_of(plane, is_free);
      })) {
    throw InputError(fmt::format("the scene {} is held nowhere: no site has a displacement that is known, so "
                                 "that any would do; give it a [[condition]] or a target",
                                 scene.name));
  }
}

/// A request is a method of its own, so what belongs to another one has no meaning beside it. Throws
/// InputError.
void require_meaning(const Arguments& arguments, const Call& call) {
  const CLI::App& command = *call.command;
  (void)arguments.request(1.0);
  if (const auto* const energy = arguments.scene.schedule.energy; arguments.asks() && energy != nullptr) {
    require_near_finite_elements(*energy, fmt::format("--energy {}", energy->name));
  }
  if (launched_together() == 0) {
    refuse_idle(command, {"--sites-per-rank", "--halo"},
                "ranks are several processes, mpirun -n 4 hdmbench run ..., and this one is alone");
  }
  if (call.ranks != nullptr) {
    refuse_idle(command, {"--accuracy", "--within"}, "that runs in one process, without mpirun");
  }
  if (arguments.asks()) {
    refuse_idle(command,
                schedule_options(command, {"--energy", "--penalty", "--prior-weight", "--alignment"}),
                "--accuracy and --within choose method, levels and iterations themselves");
  } else {
    refuse_idle(command, {"--explain"}, "it explains a plan, which --accuracy or --within ask for");
  }
}

/// What each rank did, on the first one; nothing on the others. Collective.
json rows_of_ranks(const Arguments& arguments, const std::vector<std::unique_ptr<Backend>>& registry,
                   const RankBackend& backend, const PeakMemory& memory, Ranks& ranks) {
  const Traffic traffic = ranks.traffic();
  const json own{{"machine", machine_name()},
                 {"backend", backend_of_rank(registry, arguments.scene.backend, ranks.rank()).name()},
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

/// Of the scene and of its field; a plan that was met has its error, by a method of its own.
Warnings find_warnings(const Scene& scene, const Solution& solution, const std::optional<Plan>& plan) {
  Warnings warnings;
  if (is_inspected(scene.extent())) {
    warnings = diagnose(scene);
    std::ranges::move(diagnose(scene, solution), std::back_inserter(warnings));
  }
  constexpr std::array answered{"not-converged", "stalling-cycles", "nearly-incompressible"};
  std::erase_if(warnings, [&](const Warning& warning) {
    return plan && plan->met && std::ranges::count(answered, warning.kind) > 0;
  });
  return warnings;
}

int run_scene(Arguments& arguments, Call& call) {
  require_meaning(arguments, call);
  Ranks* const ranks = call.ranks;
  const PeakMemory memory;
  Progress progress(call.speaks());
  progress.describe(fmt::format("prepare {}", arguments.scene.scene));
  const Scene scene = load_for(arguments);
  const Request request = arguments.request(scene.spacing);
  const bool inspected = is_inspected(scene.extent());
  const auto registry = make_backends();
  SessionOptions session = arguments.scene.session;
  std::optional<RankBackend> shared;
  if (ranks != nullptr) {
    shared.emplace(*ranks, registry, arguments.scene.backend, session, sharing_of(scene, arguments, *ranks));
    session.device.clear(); // a rank's own is taken already
  }
  const Backend& backend = shared ? *shared : arguments.scene.choose(registry, scene);
  const Device device = backend.device(session);
  const std::vector<std::string> files = file_names(scene, arguments.format);
  if (have_images() && call.speaks()) {
    require_folder(arguments.output, files, files_of_scene(arguments.scene.scene));
  }
  require_held(scene);
  if (arguments.format == "nii.gz" && scene.extent().axes() == 2) {
    throw InputError("--format nii.gz is for volumes: programs read a NIfTI file of one slice without its "
                     "place in space; give nrrd or mha");
  }

  progress.set_total(site_updates(scene));
  progress.describe(fmt::format("run {} on {}", scene.name, backend.name()));
  std::optional<Plan> plan;
  Solution solution;
  if (arguments.asks()) {
    plan = solve_as_needed(scene, request, backend, session, progress);
    solution = plan->solution;
  } else {
    solution = Solver(backend, session).solve(scene, progress, {.last_changed = inspected});
  }
  progress.clear();
  json by_rank = json::array();
  if (ranks != nullptr) {
    by_rank = rows_of_ranks(arguments, registry, *shared, memory, *ranks);
    if (!call.speaks()) { // all have the same field
      return success;
    }
  }
  const std::string absurd = why_absurd(scene, solution.displacement);
  const Warnings warnings = find_warnings(scene, solution, plan);
  const std::string method = plan ? "as needed" : method_name(scene);
  const double energy = absurd.empty() ? mean_energy_of(scene, solution.displacement)
                                       : std::numeric_limits<double>::quiet_NaN();
  const double largest = largest_magnitude(solution.displacement);
  const std::int64_t iterations = total_iterations(solution.levels);
  json row = with_size({{"scene", scene.name},
                        {"title", scene.title},
                        {"backend", shared ? shared->backends() : std::string(backend.name())},
                        {"device", device.name},
                        {"method", method},
                        {"energy", scene.energy->name},
                        {"seconds", solution.timings.total()},
                        {"levels", solution.levels.size()},
                        {"iterations", iterations},
                        {"mean_energy", energy},
                        {"largest_displacement", largest},
                        {"spacing", scene.spacing},
                        {"placement", scene.placement},
                        {"warnings", warnings},
                        {"field", ""}},
                       scene.extent());
  const bool is_volume = scene.extent().axes() == 3;
  const char* const unit = is_volume ? "voxels" : "px";
  fmt::print("{}\n{} {} of {:.4g} mm, {} on {} ({})\n\n", scene.title, scene.extent().text(),
             is_volume ? "voxels" : "pixels", scene.spacing, method, backend.name(), device.name);
  if (plan) {
    row["plan"] = plan_row(scene, request, *plan);
    if (arguments.explain) {
      fmt::print("{}\n",
                 table_text(row["plan"]["steps"],
                            "size|action:step|moved:moved px|expected_error:error px|seconds|reason:why"));
    }
    fmt::print("  {}; {:.3g} sweeps over the full resolution in all\n", plan->outcome,
               fine_sweep_equivalents(*plan));
  } else {
    print_levels(solution, inspected && !scene.energy->is_of_cells());
  }
  if (ranks != nullptr) {
    row.update({{"ranks", ranks->size()}, {"by_rank", by_rank}});
    fmt::print("\n{}", table_text(by_rank, "machine|backend|device|threads|messages|bytes:bytes sent|"
                                           "peak_memory:bytes at most"));
  }
  fmt::print("\n  mean energy {:.6g}, largest displacement {:.4g} {}, {} iterations in {:.3g} s\n", energy,
             largest, unit, iterations, solution.timings.total());
  if (solution.estimated_error && !plan) {
    fmt::print("  estimated distance from finite elements {:.2g} {}\n", *solution.estimated_error, unit);
  }
  if (!absurd.empty()) {
    fmt::print(
        "  NO RESULT: {}; look for extreme moduli, targets or a huge --penalty, or take another --method\n",
        absurd);
  }
  fmt::print("\n{}\n", inspected
                           ? warnings_text(warnings)
                           : "  Not diagnosed, and no pictures: beyond 4096 x 4096 sites that takes more "
                             "time and memory than the solution.\n");
  write_files(arguments.output, files, call.json, scene, solution.displacement, row);
  call.write(json::array({without_nulls(row)}));
  return absurd.empty() && (!plan || plan->met) ? success : disagreement;
}

} // namespace

void add_run(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "run",
      "Solve one scene; write the displacement in millimetres, and the picture before and after, the\n"
      "deformed grid and the displacement's magnitude and change of area or volume as PNG; say what speaks\n"
      "against the result.",
      run_scene);
  own.scene.schedule.takes_energy = true;
  own.scene.add_scene_to(command);
  own.scene.add_backend_to(command);
  add_output_folder(command, own.output);
  add_option(command, "--format", own.format, "Format of the displacement: nrrd, mha or nii.gz (NIfTI)")
      ->check(CLI::IsMember({"nrrd", "mha", "nii.gz"}));
  add_json(command, call);
  {
    const OptionGroup group(command, "No more than the scene needs");
    add_option(command, "--accuracy", own.accuracy,
               "Distance from finite elements that is good enough, RMS, as 0.2px or 0.1mm: with the "
               "elastic energy, and levels and steps that follow from the scene; exit status 1 where "
               "the estimate is above it, or cannot be trusted");
    add_option(command, "--within", own.within,
               "The time there is, as 10ms or 2s: the best field of the elastic energy and its error");
    add_flag(command, "--explain", own.explain, "Print the plan, step by step, and why");
  }
  const OptionGroup group(command, "Several processes (mpirun -n 4 hdmbench run ...)");
  add_option(command, "--sites-per-rank", own.sites_per_rank,
             "With mpirun: a level goes to as many ranks as get so many sites each, 0: 16384, of "
             "the elastic energy 4096; "
             "--backend is then one for all, or as openmp+vulkan-compute each rank's in turn, and "
             "--device may be by-rank");
  add_option(command, "--halo", own.halo,
             "With mpirun: sites that a rank computes beyond its own, a multiple of 4, on every level; "
             "0: an eighth of "
             "the shortest piece, 4 ... 64. Of the elastic energy those of the coarsest level that is "
             "cut, even; 0: 4. The bits are the same")
      ->check(CLI::Range(0, 1024));
}

} // namespace hdmbench::commands
