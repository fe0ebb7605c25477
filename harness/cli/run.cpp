#include "harness/check/compare.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/plan_text.hpp"
#include "harness/cli/rank_rows.hpp"
#include "harness/cli/strain_images.hpp"
#include "harness/judge/diagnosis/deformation.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/run_row.hpp"
#include "harness/measure/memory_use.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/ranks/launch.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/ranks/rank_devices.hpp"
#include "harness/report/grouped.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/robust_observations.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/planner.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/level.hpp"
#include "reference/finite_elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;

struct Arguments {
  SceneArguments scene;
  fs::path output = "hdmbench-output";
  fs::path json;
  std::string accuracy; ///< "0.2px" or "0.1mm"; empty: not asked for
  std::string within;   ///< "10ms"; empty: not asked for
  bool explain = false;
  std::size_t sites_per_rank = 0; ///< of Sharing
  int halo = 0;                   ///< the same
  bool strains = false;

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

RunRow::Pictures picture_names(const Scene& scene) {
  const auto name = [&](const char* what) { return fmt::format("{}-{}.png", scene.name, what); };
  return {.before = name("before"),
          .after = name("after"),
          .grid = name("grid"),
          .magnitude = name("magnitude"),
          .jacobian = name("jacobian")};
}

/// What goes to the output folder: the field first.
std::vector<std::string> file_names(const Scene& scene, bool strains) {
  std::vector<std::string> names{scene.name + ".nrrd"};
  if (is_inspected(scene.extent())) {
    const RunRow::Pictures pictures = picture_names(scene);
    names.insert(names.end(),
                 {pictures.before, pictures.after, pictures.grid, pictures.magnitude, pictures.jacobian});
  }
  if (strains) {
    std::ranges::move(strain_image_names(scene), std::back_inserter(names));
  }
  return names;
}

/// File names, relative to `folder`.
RunRow::Pictures write_pictures(const Scene& scene, const VectorField& displacement, const fs::path& folder) {
  const RunRow::Pictures names = picture_names(scene);
  write_png(folder / names.before, scene.picture);
  write_png(folder / names.after, warp(scene.picture, displacement));
  write_png(folder / names.grid,
            warp(grid_picture(scene.extent(), grid_spacing(scene.extent())), displacement));
  write_magnitude_png(folder / names.magnitude, displacement,
                      std::max(largest_magnitude(displacement), 1e-6));
  // Full blue is a fold, full red a doubled area.
  write_signed_png(folder / names.jacobian, scene.extent(), area_change_map(displacement).values, 1.0);
  return names;
}

/// `counted`: whether solution.levels have counts of changes.
void print_levels(const Solution& solution, bool counted) {
  std::vector<Table::Column> columns{"level", "size", "iterations"};
  if (counted) {
    columns.push_back("still moving");
  }
  Table table(std::move(columns));
  bool repeated = false;
  for (const LevelResult& level : solution.levels) {
    repeated = repeated || level.repeated;
    std::vector<std::string> row{std::to_string(level.level),
                                 fmt::format("{} x {}", level.extent.width, level.extent.height),
                                 fmt::format("{}{}", level.iterations, level.repeated ? " *" : "")};
    if (counted) {
      row.push_back(fmt::format("{} sites", level.changed));
    }
    table.add(std::move(row));
  }
  fmt::print("{}{}", table.text(), repeated ? "  * acceleration diverged, computed again without\n" : "");
}

/// Of the energy that the displacement minimises, over sites.
double mean_energy_of(const Scene& scene, const VectorField& displacement) {
  if (scene.energy == EnergyModel::hdm) {
    return mean_energy(scene.full, displacement);
  }
  const Level& level = scene.robust ? reweighted(scene.full, displacement, *scene.robust) : scene.full;
  const double twice = elastic_energy(elastic_problem(level), ElementRule::plane_stress(scene.poisson),
                                      ReferenceField(displacement));
  return twice / 2.0 / static_cast<double>(scene.extent().sites());
}

/// Of the scene and of its field.
Warnings find_warnings(const Scene& scene, const Solution& solution) {
  Warnings warnings = diagnose(scene);
  std::ranges::move(diagnose(scene, solution), std::back_inserter(warnings));
  return warnings;
}

/// How ranks share the scene out. Throws InputError where they cannot.
Sharing sharing_of(const Scene& scene, const Arguments& arguments, const Ranks& ranks) {
  const bool is_elastic = scene.energy == EnergyModel::elastic;
  const int granule = is_elastic ? 2 : 4;
  if (arguments.halo % granule != 0) {
    throw InputError(fmt::format("--halo {}: a multiple of {}{}, or 0", arguments.halo, granule,
                                 is_elastic ? " for the elastic energy" : ""));
  }
  if (scene.full.update == Update::sequential) {
    throw InputError("sequential, each of whose sweeps crosses the image site by site, runs on one rank");
  }
  return {.ranks = ranks.size(),
          .pieces = ranks.size(),
          .fewest_sites = arguments.sites_per_rank,
          .halo = arguments.halo};
}

void print_ranks(const std::vector<RankRow>& rows) {
  Table table({"rank", "<machine", "<backend", "<device", "threads", "messages", "MB sent", "peak MB"});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const RankRow& row = rows[i];
    const auto megabytes = [](std::int64_t bytes, int digits) {
      return fmt::format("{:.{}f}", static_cast<double>(bytes) / 1e6, digits);
    };
    table.add({std::to_string(i), row.machine, row.backend, row.device,
               row.threads > 0 ? std::to_string(row.threads) : "-", grouped(row.messages),
               megabytes(row.bytes, 2), row.peak_memory > 0 ? megabytes(row.peak_memory, 0) : "-"});
  }
  fmt::print("\n{}", table.text());
}

/// Throws InputError for a request with the thesis's energy, which `says` asks for.
[[noreturn]] void refuse_thesis_energy(std::string_view says) {
  throw InputError(fmt::format(
      "--accuracy and --within ask for a distance from finite elements, which the elastic energy comes near "
      "and the thesis's does not, however long it is solved; {} asks for the thesis's: give --energy "
      "elastic, or --method and --iterations in place of --accuracy and --within",
      says));
}

/// The scene, which a request solves with the elastic energy.
Scene load_for(const Arguments& arguments) {
  if (!arguments.asks() || arguments.scene.schedule.energy) {
    return arguments.scene.load();
  }
  SceneArguments elastic = arguments.scene;
  elastic.schedule.energy = EnergyModel::elastic;
  Scene scene = elastic.load();
  if (scene.stated_energy == EnergyModel::hdm) {
    refuse_thesis_energy(scene.source);
  }
  return scene;
}

/// A request is a method of its own, so what belongs to another one has no meaning beside it. Throws
/// InputError.
void require_meaning(const Arguments& arguments, const Command& command, const Ranks* ranks) {
  if (arguments.asks() && arguments.scene.schedule.energy == EnergyModel::hdm) {
    refuse_thesis_energy("--energy hdm");
  }
  refuse_idle(command,
              {{.here = launched_together() == 0,
                .options = {"--sites-per-rank", "--halo"},
                .why = "ranks are several processes, mpirun -n 4 hdmbench run ..., and this one is alone"},
               {.here = ranks != nullptr,
                .options = {"--accuracy", "--within"},
                .why = "that runs in one process, without mpirun"},
               {.here = !arguments.asks(),
                .options = {"--explain"},
                .why = "it explains a plan, which --accuracy or --within ask for"},
               {.here = arguments.asks(),
                .options = {"--method", "--iterations", "--start-level", "--stride", "--stop", "--epsilon",
                            "--update", "--steps", "--relaxation", "--temperatures", "--seed"},
                .why = "--accuracy and --within choose method, levels and iterations themselves"}});
}

int run_scene(const Arguments& arguments, const Command& command, const std::string& line, Ranks* ranks) {
  require_meaning(arguments, command, ranks);
  (void)arguments.request(1.0); // before long work
  const PeakMemory memory;
  const bool is_first = ranks == nullptr || ranks->is_first();
  Progress progress(is_first);
  progress.describe(fmt::format("prepare {}", arguments.scene.scene));
  const Scene scene = load_for(arguments);
  const Request request = arguments.request(scene.spacing);
  if (arguments.strains && !(have_images() && is_inspected(scene.extent()))) {
    throw InputError(have_images() ? "--strains is for images of at most 4096 x 4096 sites"
                                   : "--strains needs image support, which this build has not "
                                     "(-DHDMBENCH_IMAGES=ON)");
  }
  const auto registry = make_backends();
  SessionOptions session = arguments.scene.session;
  std::optional<RankBackend> shared;
  if (ranks != nullptr) {
    shared.emplace(*ranks, registry, arguments.scene.backend, session, sharing_of(scene, arguments, *ranks));
    session.device.clear(); // a rank's own is taken already
  }
  const Backend& backend = shared ? *shared : arguments.scene.choose(registry, scene);
  const Device device = backend.device(session);
  if (is_first) {
    require_results_writable(arguments.json);
  }
  if (have_images() && is_first) {
    require_folder(arguments.output, file_names(scene, arguments.strains), arguments.scene.files());
  }

  const bool inspected = is_inspected(scene.extent());
  const bool counted = inspected && scene.energy == EnergyModel::hdm;
  progress.set_total(site_updates(scene), WorkUnit::site_updates);
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
  std::vector<RankRow> by_rank;
  if (ranks != nullptr) {
    const Traffic traffic = ranks->traffic();
    by_rank = gather_rows<RankRow>(
        {{.machine = machine_name(),
          .backend = std::string(backend_of_rank(registry, arguments.scene.backend, ranks->rank()).name()),
          .device = device.name,
          .threads = backend.threads(session),
          .messages = traffic.messages,
          .bytes = traffic.bytes,
          .peak_memory = static_cast<std::int64_t>(memory.bytes().value_or(0))}},
        *ranks);
    if (!is_first) { // all have the same field
      return success;
    }
  }
  Warnings warnings = inspected ? find_warnings(scene, solution) : Warnings{};
  if (plan && plan->met) { // the error is what was asked for, by a method of the plan's own
    std::erase_if(warnings, [](const Warning& warning) {
      return warning.kind == "not-converged" || warning.kind == "stalling-cycles";
    });
  }

  const std::int64_t iterations = total_iterations(solution.levels);
  const std::string absurd = why_absurd(scene, solution.displacement);
  const double energy = std::isfinite(largest_found(solution.displacement))
                            ? mean_energy_of(scene, solution.displacement)
                            : std::numeric_limits<double>::quiet_NaN();
  const double largest = largest_magnitude(solution.displacement);
  fmt::print("{}\n{} x {} pixels of {:.4g} mm, {} on {} ({})\n\n", scene.title, scene.extent().width,
             scene.extent().height, scene.spacing, plan ? "as needed" : method_name(scene), backend.name(),
             device.name);
  if (plan && arguments.explain) {
    fmt::print("{}", plan_text(scene, *plan));
  } else if (!plan) {
    print_levels(solution, counted);
  }
  if (ranks != nullptr) {
    print_ranks(by_rank);
  }
  if (plan) {
    fmt::print("\n  {}; {:.3g} sweeps over the full resolution in all\n", plan->outcome,
               fine_sweep_equivalents(*plan));
  }
  fmt::print("\n  mean energy {:.6g}, largest displacement {:.4g} px, {} iterations in {:.3g} s\n", energy,
             largest, iterations, solution.timings.total());
  if (solution.estimated_error && !plan) {
    fmt::print("  estimated distance from finite elements {:.2g} px\n", *solution.estimated_error);
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

  RunRow row{.scene = scene.name,
             .title = scene.title,
             .width = scene.extent().width,
             .height = scene.extent().height,
             .backend = shared ? shared->backends() : std::string(backend.name()),
             .device = device.name,
             .method = plan ? "as needed" : method_name(scene),
             .energy = std::string(energy_names[static_cast<std::size_t>(scene.energy)]),
             .seconds = solution.timings.total(),
             .levels = std::ssize(solution.levels),
             .iterations = iterations,
             .mean_energy = energy,
             .largest_displacement = largest,
             .spacing = scene.spacing,
             .placement = scene.placement,
             .warnings = warnings};
  if (ranks != nullptr) {
    row.ranks = ranks->size();
    row.by_rank = std::move(by_rank);
  }
  if (plan) {
    row.plan = plan_row(scene, request, *plan);
  }
  if (have_images()) {
    const std::string field = scene.name + ".nrrd";
    write_displacement(arguments.output / field, solution.displacement, scene.spacing, scene.placement);
    fmt::print("  {}: the displacement in millimetres\n", (arguments.output / field).string());
    if (inspected) {
      row.pictures = write_pictures(scene, solution.displacement, arguments.output);
      fmt::print("  beside it {}, {}, {}, {} and {}\n", row.pictures->before, row.pictures->after,
                 row.pictures->grid, row.pictures->magnitude, row.pictures->jacobian);
    }
    if (arguments.strains) {
      row.strains = write_strain_images(scene, solution.displacement, arguments.output);
    }
    if (!arguments.json.empty()) {
      const fs::path folder = fs::proximate(arguments.output, fs::absolute(arguments.json).parent_path());
      const auto beside_json = [&](const std::string& name) {
        return (folder / name).lexically_normal().string();
      };
      row.field = beside_json(field);
      std::ranges::transform(row.strains, row.strains.begin(), beside_json);
      if (row.pictures) {
        RunRow::Pictures& names = *row.pictures;
        for (std::string* const name :
             {&names.before, &names.after, &names.grid, &names.magnitude, &names.jacobian}) {
          *name = beside_json(*name);
        }
      }
    }
  } else {
    fmt::print("  No files are written: this build has no image support (-DHDMBENCH_IMAGES=ON).\n");
  }
  write_results(arguments.json, "run", run_context(line, false), nlohmann::json::array({to_json_row(row)}));
  return absurd.empty() && (!plan || plan->met) ? success : disagreement;
}

} // namespace

void add_run(const Command& program, const std::string& arguments, int& status, Ranks* ranks) {
  const Command command = program.add_subcommand(
      "run", "Solve one scene; write the displacement as NRRD, and the "
             "picture before and after, the deformed grid and\n"
             "the displacement's magnitude and change of area as PNG; say what speaks against the result.");
  const auto own = std::make_shared<Arguments>();
  own->scene.schedule.takes_elastic = true;
  own->scene.schedule.is_of_run = true;
  own->scene.add_scene_to(command);
  own->scene.add_backend_to(command);
  command.add_option("--output", own->output, "Folder for the files, made if missing").capture_default_str();
  command.add_flag("--strains", own->strains,
                   "Write strains, von Mises stress and change of area as well, as NRRD and PNG");
  command.add_option("--json", own->json, "Write the result to this file");
  const auto* const group = "No more than the scene needs";
  command
      .add_option(
          "--accuracy", own->accuracy,
          "Distance from finite elements that is good enough, RMS, as 0.2px or 0.1mm: with the elastic "
          "energy, "
          "and levels and steps that follow from the scene; exit status 1 where the estimate is above it, or "
          "cannot be trusted")
      .group(group);
  command
      .add_option("--within", own->within,
                  "The time there is, as 10ms or 2s: the best field of the elastic energy and its error")
      .group(group);
  command.add_flag("--explain", own->explain, "Print the plan, step by step, and why").group(group);
  const std::string several = "Several processes (mpirun -n 4 hdmbench run ...)";
  constexpr int widest_halo = 1024;
  command
      .add_option(
          "--sites-per-rank", own->sites_per_rank,
          "With mpirun: a level goes to as many ranks as get so many sites each, 0: 16384, of the elastic "
          "energy 4096; --backend "
          "is then one for all, or as openmp+vulkan-compute each rank's in turn, and --device may be "
          "by-rank")
      .group(several);
  command
      .add_option(
          "--halo", own->halo,
          "With mpirun: sites that a rank computes beyond its own, a multiple of 4, on every level; 0: "
          "an eighth of the shortest piece, 4 ... 64. Of the elastic energy those of the "
          "coarsest level that is cut, even; 0: 4. The bits are the same")
      .range(0, widest_halo)
      .group(several);
  command.callback(
      [own, command, arguments, &status, ranks] { status = run_scene(*own, command, arguments, ranks); });
}

} // namespace hdmbench::commands
