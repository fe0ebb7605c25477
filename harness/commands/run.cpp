#include "harness/commands/arguments.hpp"
#include "harness/commands/commands.hpp"
#include "harness/compare.hpp"
#include "harness/context.hpp"
#include "harness/diagnosis/diagnosis.hpp"
#include "harness/diagnosis/folding.hpp"
#include "harness/file_output.hpp"
#include "harness/images.hpp"
#include "harness/solve.hpp"
#include "harness/table.hpp"
#include "kernels/input_error.hpp"
#include "kernels/mean_energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;

struct Arguments {
  SceneArguments scene;
  fs::path output = "hdmbench-output";
  fs::path json;
};

/// File names by what they show, relative to `folder`.
nlohmann::json write_pictures(const Scene& scene, const VectorField& displacement, const fs::path& folder) {
  nlohmann::json names;
  const auto file = [&](const char* what) {
    names[what] = fmt::format("{}-{}.png", scene.name, what);
    return folder / std::string(names[what]);
  };
  write_png(file("before"), scene.picture);
  write_png(file("after"), warp(scene.picture, displacement));
  write_png(file("grid"), warp(grid_picture(scene.extent(), grid_spacing(scene.extent())), displacement));
  write_magnitude_png(file("magnitude"), displacement, std::max(largest_magnitude(displacement), 1e-6));
  // Full blue is a fold, full red a doubled area.
  write_signed_png(file("jacobian"), scene.extent(), area_change_map(displacement).values, 1.0);
  return names;
}

void print_levels(const Solution& solution) {
  Table table({{"level", Table::Align::right},
               {"size", Table::Align::right},
               {"iterations", Table::Align::right},
               {"still moving", Table::Align::right}});
  for (const LevelResult& level : solution.levels) {
    table.add({std::to_string(level.level), fmt::format("{} x {}", level.extent.width, level.extent.height),
               std::to_string(level.iterations), fmt::format("{} sites", level.changed)});
  }
  fmt::print("{}", table.text());
}

/// Of the scene and of its field.
Warnings find_warnings(const Scene& scene, const Solution& solution) {
  Warnings warnings = diagnose(scene);
  std::ranges::move(diagnose(scene, solution), std::back_inserter(warnings));
  return warnings;
}

void run_scene(const Arguments& arguments, const std::string& line) {
  const Scene scene = arguments.scene.load();
  const auto registry = make_backends();
  const Backend& backend = arguments.scene.choose(registry, scene);
  const Device device = backend.device(arguments.scene.session);
  if (!arguments.json.empty()) {
    require_writable(arguments.json);
  }
  if (have_images()) {
    std::error_code error;
    fs::create_directories(arguments.output, error);
    require_writable(arguments.output / "field.nrrd");
  }

  Progress progress;
  progress.set_total(site_updates(scene));
  progress.describe(fmt::format("run {} on {}", scene.name, backend.name()));
  const auto session = backend.open(arguments.scene.session);
  const Solution solution = solve(scene, *session, progress, {.last_changed = true});
  progress.clear();
  const Warnings warnings = find_warnings(scene, solution);

  const std::int64_t iterations = total_iterations(solution.levels);
  const double energy = mean_energy(scene.full, solution.displacement);
  const double largest = largest_magnitude(solution.displacement);
  fmt::print("{}\n{} x {} pixels of {:.4g} mm, {} on {} ({})\n\n", scene.title, scene.extent().width,
             scene.extent().height, scene.spacing, method_name(scene.schedule), backend.name(), device.name);
  print_levels(solution);
  fmt::print("\n  mean energy {:.6g}, largest displacement {:.4g} px, {} iterations in {:.3g} s\n", energy,
             largest, iterations, solution.timings.total());
  fmt::print("\n{}\n", warnings_text(warnings));

  nlohmann::json row{{"scene", scene.name},
                     {"title", scene.title},
                     {"width", scene.extent().width},
                     {"height", scene.extent().height},
                     {"backend", backend.name()},
                     {"device", device.name},
                     {"method", method_name(scene.schedule)},
                     {"seconds", solution.timings.total()},
                     {"levels", solution.levels.size()},
                     {"iterations", iterations},
                     {"mean_energy", energy},
                     {"largest_displacement", largest},
                     {"spacing", scene.spacing},
                     {"warnings", warnings_json(warnings)}};
  if (have_images()) {
    const std::string field = scene.name + ".nrrd";
    write_displacement(arguments.output / field, solution.displacement, scene.spacing);
    nlohmann::json pictures = write_pictures(scene, solution.displacement, arguments.output);
    fmt::print("  {}: the displacement in millimetres; beside it {}, {}, {}, {} and {}\n",
               (arguments.output / field).string(), std::string(pictures["before"]),
               std::string(pictures["after"]), std::string(pictures["grid"]),
               std::string(pictures["magnitude"]), std::string(pictures["jacobian"]));
    if (!arguments.json.empty()) {
      const fs::path relative = fs::proximate(arguments.output, fs::absolute(arguments.json).parent_path());
      row["field"] = (relative / field).lexically_normal().string();
      for (auto& name : pictures) {
        name = (relative / std::string(name)).lexically_normal().string();
      }
      row["pictures"] = pictures;
    }
  } else {
    fmt::print("  No files are written: this build has no image support (-DHDMBENCH_IMAGES=ON).\n");
  }
  if (!arguments.json.empty()) {
    write_results(arguments.json, "run", run_context(line, false), nlohmann::json::array({row}));
  }
}

} // namespace

void add_run(CLI::App& program, const std::string& arguments, int& /*status*/) {
  auto* command = program.add_subcommand(
      "run", "Solve one scene; write the displacement as NRRD, and the "
             "picture before and after, the deformed grid and\n"
             "the displacement's magnitude and change of area as PNG; say what speaks against the result.");
  const auto own = std::make_shared<Arguments>();
  own->scene.add_scene_to(*command);
  own->scene.add_backend_to(*command);
  command->add_option("--output", own->output, "Folder for the files, made if missing")
      ->capture_default_str();
  command->add_option("--json", own->json, "Write the result to this file");
  command->callback([own, arguments] { run_scene(*own, arguments); });
}

} // namespace hdmbench::commands
