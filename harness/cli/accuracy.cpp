#include "harness/judge/accuracy.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/judged_text.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/images/images.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/published.hpp"

#include <fmt/format.h>

#include <algorithm>
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

void print_fields(const SceneAccuracy& accuracy) {
  std::vector<const Judged*> shown;
  std::string remarks;
  for (const Judged& row : accuracy.rows) {
    if (!row.seconds.empty()) {
      shown.push_back(&row);
    }
    if (row.variant.empty() && !row.note.empty()) {
      remarks += fmt::format("  {}: {}\n", name_of(row), row.note);
    }
  }
  fmt::print("{}{}{}", table_text(shown), failures_text(accuracy.rows), remarks);
}

void print_arithmetic(const SceneAccuracy& accuracy) {
  Table table({"<float32 against double", "steps", "other candidate", "beyond bound", "gap / bound"});
  bool any = false;
  for (const Judged& row : accuracy.rows) {
    if (row.arithmetic) {
      any = true;
      const ArithmeticError& error = *row.arithmetic;
      table.add({row.backend, std::to_string(error.steps_compared), std::to_string(error.steps_differing),
                 std::to_string(error.beyond_bound), fmt::format("{:.2g}", error.largest_gap_over_bound)});
    }
  }
  if (any) {
    fmt::print("\n{}", table.text());
  }
}

/// Prints what is wrong with a scene's results; true if nothing is.
bool is_sound(const SceneAccuracy& accuracy) {
  bool sound = true;
  for (const Judged& row : accuracy.rows) {
    const bool may_fail = row.method == registration_name; // its mistakes are its own
    sound = sound && (row.status == JudgedStatus::ok || row.status == JudgedStatus::skipped || may_fail);
    if (row.arithmetic && row.arithmetic->beyond_bound > 0) {
      fmt::print("  {}: {} steps lose more energy than rounding explains\n", name_of(row),
                 row.arithmetic->beyond_bound);
      sound = false;
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
    print_fields(accuracy);
    print_arithmetic(accuracy);
    sound = is_sound(accuracy) && sound;
    std::fflush(stdout); // into a pipe too: the next scene may take long
    bool pictured = folder.empty() || !have_images();
    for (const Judged& row : accuracy.rows) {
      rows.push_back(to_json(scene, row));
      if (!pictured && row.method == "icm" && !row.field.x.empty()) {
        rows.back()["differences"] = write_difference(scene, accuracy.truths, row, folder);
        pictured = true;
      }
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
  command.add_option("--repeat", own->repeats, "Samples of the seconds, fewer where they take long")
      .range(1, 1'000'000)
      .capture_default_str();
  command.add_flag("--full", own->full,
                   "Sizes 300, 600 and 1200, and every iteration against double: takes long");
  command.callback([own, command, arguments, &status] { status = run_accuracy(*own, command, arguments); });
}

} // namespace hdmbench::commands
