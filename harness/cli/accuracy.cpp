#include "harness/judge/accuracy/accuracy.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/judge/accuracy/accuracy_row.hpp"
#include "harness/measure/median.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/images/images.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/published.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace hdmbench::commands {

namespace {

struct Arguments : CommonArguments {
  int repeats = 3;
  bool full = false;
};

/// Chapter 5 of the thesis, and the brain.
std::vector<std::string> scenes_by_default() {
  return {"square", "square-modified", "square-single-level", "circular", "circular-radial", "brain"};
}

/// Where pictures carry enough texture for a registration to find its way (thesis 5.11).
bool is_registered(const Scene& scene) {
  return scene.name == "circular" || scene.name == "brain";
}

/// Rounding of the decomposition, relative to the squared total.
constexpr double rounding_of_squares = 1e-10;

std::string pixels(double value) {
  if (std::abs(value) < 1e-3) {
    return value == 0.0 ? "0" : fmt::format("{:.1e}", value);
  }
  return fmt::format("{:.{}f}", value, value < 0.1 ? 4 : value < 10.0 ? 3 : 2);
}

std::string row_name(const JudgedField& row) {
  std::string name = row.method;
  if (row.poisson_used) {
    name += fmt::format(", nu {:.2g}", *row.poisson_used);
  }
  if (!row.backend.empty() && row.variant.empty()) {
    name += fmt::format(" on {}", row.backend);
  }
  if (!row.valid && !row.field.x.empty()) {
    name += " (NOT VALID)";
  }
  return row.variant.empty() ? name : fmt::format("{}: {}", name, row.variant);
}

void print_published(const Scene& scene) {
  if (scene.extent() != Extent{300, 300}) {
    return;
  }
  for (const PublishedAccuracy& row : published_accuracy()) {
    if (row.scene != scene.name) {
      continue;
    }
    if (row.rmsd) {
      fmt::print("  thesis, table {}: {} {} px to FEM, mean energy {}, {} iterations, {} s\n", row.table,
                 row.method, *row.rmsd, *row.mean_energy, *row.iterations, row.seconds);
    } else {
      fmt::print("  thesis, table {}: {} {} s\n", row.table, row.method, row.seconds);
    }
  }
}

void print_fields(const Scene& scene, const SceneAccuracy& accuracy) {
  const bool interfaces = accuracy.rows.front().deviations.interface_to_fem.has_value();
  std::vector<Table::Column> columns{
      "<RMSD in pixels to", {fmt::format("FEM nu {:.2g}", scene.poisson)}, "FEM nu 0", "fixed point"};
  if (interfaces) {
    columns.push_back({"interfaces"});
    columns.push_back({"elsewhere"});
  }
  columns.insert(columns.end(), {{"mean energy"}, {"iterations"}, {"seconds"}});
  Table table(columns);
  std::string remarks;
  for (const JudgedField& row : accuracy.rows) {
    if (row.status != "ok") {
      remarks += fmt::format("  {}: {}\n", row_name(row), row.status);
    }
    if (row.variant.empty() && !row.note.empty()) {
      remarks += fmt::format("  {}: {}\n", row_name(row), row.note);
    }
    if (row.field.x.empty()) {
      continue;
    }
    const Deviations& deviations = row.deviations;
    std::vector<std::string> cells{row_name(row), pixels(deviations.to_fem),
                                   pixels(deviations.to_fem_no_poisson), pixels(deviations.to_fixed_point)};
    if (interfaces) {
      cells.push_back(pixels(*deviations.interface_to_fem));
      cells.push_back(pixels(*deviations.elsewhere_to_fem));
    }
    cells.push_back(fmt::format("{:.5g}", row.mean_energy));
    cells.push_back(row.levels.empty() ? "" : std::to_string(total_iterations(row.levels)));
    cells.push_back(fmt::format("{:.3g}", median(row.seconds)));
    table.add(std::move(cells));
  }
  fmt::print("{}{}", table.text(), remarks);
}

void print_decompositions(const SceneAccuracy& accuracy) {
  Table table({"<where it comes from", "nu", "total", "model", "optimisation", "2 covariance", "remainder"});
  const JudgedField* before = nullptr;
  for (const JudgedField& row : accuracy.rows) {
    // The backends' rows are equal where they agree.
    const bool repeated = before != nullptr && before->method == row.method && row.valid;
    if (row.decompositions.empty() || !row.variant.empty() || repeated) {
      continue;
    }
    before = &row;
    for (const auto& [poisson, parts] : row.decompositions) {
      table.add({row.method, fmt::format("{:.2g}", poisson), pixels(parts.total), pixels(parts.model),
                 pixels(parts.optimisation), fmt::format("{:+.4f} px^2", 2.0 * parts.covariance),
                 fmt::format("{:.1e}", parts.remainder())});
    }
  }
  if (before != nullptr) {
    fmt::print("\n{}", table.text());
  }
}

void print_arithmetic(const SceneAccuracy& accuracy) {
  Table table({"<float32 against double", "steps", "other candidate", "beyond bound", "gap / bound",
               "one iteration", "whole run"});
  bool any = false;
  for (const JudgedField& row : accuracy.rows) {
    if (row.arithmetic) {
      any = true;
      const ArithmeticError& error = *row.arithmetic;
      table.add({row.backend, std::to_string(error.steps_compared), std::to_string(error.steps_differing),
                 std::to_string(error.beyond_bound), fmt::format("{:.2g}", error.largest_gap_over_bound),
                 fmt::format("{:.2e} px", error.rmsd()),
                 row.rmsd_to_double ? pixels(*row.rmsd_to_double) + " px" : ""});
    }
  }
  if (any) {
    fmt::print("\n{}", table.text());
  }
}

/// Prints what is wrong with a scene's results; true if nothing is.
bool is_sound(const SceneAccuracy& accuracy) {
  bool sound = true;
  for (const JudgedField& row : accuracy.rows) {
    const bool skipped = row.field.x.empty() && row.status.starts_with("skipped");
    const bool rival = row.method == registration_name; // its mistakes are its own
    sound = sound && (row.valid || skipped || rival);
    if (row.arithmetic && row.arithmetic->beyond_bound > 0) {
      fmt::print("  {}: {} steps lose more energy than rounding explains\n", row_name(row),
                 row.arithmetic->beyond_bound);
      sound = false;
    }
    for (const auto& [poisson, parts] : row.decompositions) {
      if (!(std::abs(parts.remainder()) <= rounding_of_squares * (1.0 + parts.total * parts.total))) {
        fmt::print("  {}: the decomposition misses {:.3g} px^2\n", row_name(row), parts.remainder());
        sound = false;
      }
    }
  }
  return sound;
}

int run_accuracy(Arguments& arguments, const Command& command, const std::string& line) {
  refuse_idle(command,
              {{.here = true,
                .options = {"--method", "--methods"},
                .why = "accuracy measures icm, and with --energy elastic all its methods; bench takes them"},
               {.here = arguments.quick, .options = {"--full"}, .why = "--quick asks for the opposite"},
               {.here = true,
                .options = {"--update", "--stop", "--epsilon"},
                .why = "accuracy runs both designs of the thesis, simultaneous with fixed iterations and in "
                       "place until nothing moves"}});
  require_results_writable(arguments.json);
  if (arguments.full && arguments.sizes.empty()) {
    arguments.sizes = {"300", "600", "1200"};
  }
  const auto registry = make_backends();
  const std::vector<const Backend*> backends = arguments.choose(registry);
  const std::vector<Scene> scenes = arguments.load_scenes(scenes_by_default());
  const auto is_elastic = [](const Scene& scene) { return scene.energy == EnergyModel::elastic; };
  if (arguments.schedule.iterations && std::ranges::any_of(scenes, is_elastic)) {
    throw InputError("accuracy takes every elastic method at its usual effort; leave out --iterations");
  }
  const std::filesystem::path folder =
      arguments.json.empty() ? "" : std::filesystem::absolute(arguments.json).parent_path();
  AccuracyOptions options{.session = arguments.session,
                          .repeats = arguments.repeats,
                          .quick = arguments.quick,
                          .arithmetic_stride = arguments.full ? 1 : 10};
  fmt::print(
      "RMSD over all sites, in pixels. Interfaces, elsewhere: to FEM with the scene's nu, over the free "
      "sites within 5 px of\ntwo materials and over all other free sites.\n");
  Progress progress;
  nlohmann::json rows = nlohmann::json::array();
  bool sound = true;
  for (const Scene& scene : scenes) {
    options.registration = have_images() && !arguments.quick && is_registered(scene);
    const SceneAccuracy accuracy = measure_accuracy(scene, backends, options, progress);
    progress.clear();
    fmt::print("\n{}, {} x {}: {}\n", scene.name, scene.extent().width, scene.extent().height, scene.title);
    print_published(scene);
    print_fields(scene, accuracy);
    print_decompositions(accuracy);
    print_arithmetic(accuracy);
    sound = is_sound(accuracy) && sound;
    std::fflush(stdout); // into a pipe too: the next scene may take long
    for (const AccuracyRow& row : accuracy_rows(scene, accuracy, have_images() ? folder : "", folder)) {
      rows.push_back(to_json_row(row));
    }
  }
  write_results(arguments.json, "accuracy", run_context(line, arguments.quick), std::move(rows));
  return sound ? success : disagreement;
}

} // namespace

void add_accuracy(const Command& program, const std::string& arguments, int& status) {
  const Command command = program.add_subcommand(
      "accuracy",
      "Measure every method against finite elements and the exact fixed point: Tables 5.1, 5.3, 5.5 and 5.7\n"
      "of the thesis by default, and a brain. Exit status 1 where a field is not scalar's to the bit or a "
      "step\n"
      "is not explained by rounding.");
  const auto own = std::make_shared<Arguments>();
  own->schedule.takes_elastic = true;
  own->add_to(command);
  leave_out_of_help(command, {"--method", "--methods", "--update", "--stop", "--epsilon"});
  command.add_option("--repeat", own->repeats, "Samples of the seconds")
      .range(1, 1'000'000)
      .capture_default_str();
  command.add_flag("--full", own->full,
                   "Sizes 300, 600 and 1200, and every iteration against double: takes long");
  command.callback([own, command, arguments, &status] { status = run_accuracy(*own, command, arguments); });
}

} // namespace hdmbench::commands
