#include "harness/judge/accuracy.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/cli/judged_text.hpp"
#include "harness/report/published.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"

#include <cstdio>

namespace hdmbench::commands {

namespace {

struct Arguments : CommonArguments {
  int repeats = 3;
};

void print_published(const Scene& scene) {
  for (const json& row : published()["accuracy"]) {
    if (row["scene"] == scene.name && scene.extent() == Extent{300, 300}) {
      fmt::print("  thesis, table {}: {} {}{} s\n", row["table"].get<std::string>(),
                 row["method"].get<std::string>(),
                 row.contains("rmsd")
                     ? fmt::format("{} px to FEM, mean energy {}, {} iterations, ", row["rmsd"].get<double>(),
                                   row["mean_energy"].get<double>(), row["iterations"].get<int>())
                     : "",
                 row["seconds"].get<double>());
    }
  }
}

/// `rows`: as to_json() has them.
void print_scene(const SceneAccuracy& accuracy, const json& rows) {
  json fields = json::array();
  json arithmetic = json::array();
  for (const json& row : rows) {
    if (!row["seconds"].empty()) {
      fields.push_back(row);
    }
    if (row.contains("arithmetic")) {
      arithmetic.push_back(row);
    }
  }
  fmt::print("{}{}", judged_table(fields), failures_text(accuracy.rows));
  for (const Judged& row : accuracy.rows) {
    if (row.variant.empty() && !row.note.empty()) {
      fmt::print("  {}: {}\n", name_of(row), row.note);
    }
  }
  if (!arithmetic.empty()) {
    fmt::print("\n{}",
               table_text(arithmetic,
                          "backend:float32 against double|arithmetic.resynchronised.steps_compared:steps|"
                          "arithmetic.resynchronised.steps_differing:other candidate|"
                          "arithmetic.resynchronised.beyond_bound:beyond bound|"
                          "arithmetic.resynchronised.largest_gap_over_bound:gap / bound"));
  }
}

/// Prints what is wrong with a scene's results; true if nothing is.
bool is_sound(const SceneAccuracy& accuracy) {
  bool sound = true;
  for (const Judged& row : accuracy.rows) {
    sound = sound && (row.status == JudgedStatus::ok || row.status == JudgedStatus::skipped);
    if (row.arithmetic && row.arithmetic->beyond_bound > 0) {
      fmt::print("  {}: {} steps lose more energy than rounding explains\n", name_of(row),
                 row.arithmetic->beyond_bound);
      sound = false;
    }
  }
  return sound;
}

int run_accuracy(Arguments& arguments, Call& call) {
  const auto registry = make_backends();
  const std::vector<const Backend*> backends = arguments.choose(registry);
  const std::vector<Scene> scenes = arguments.load_scenes(
      {"square", "square-modified", "square-single-level", "circular", "circular-radial", "brain"});
  const auto is_of_cells = [](const Scene& scene) { return scene.energy->is_of_cells(); };
  if (arguments.schedule.iterations && std::ranges::any_of(scenes, is_of_cells)) {
    throw InputError("accuracy takes every elastic method at its usual effort; leave out --iterations");
  }
  const std::filesystem::path folder = call.json.parent_path();
  const AccuracyOptions options{
      .session = arguments.session, .repeats = arguments.repeats, .quick = arguments.quick};
  fmt::print("RMSD over all sites, in pixels. Interfaces, elsewhere: to FEM with the scene's nu, over the\n"
             "free sites within 5 px of two materials and over all other free sites.\n");
  Progress progress;
  json rows = json::array();
  bool sound = true;
  for (const Scene& scene : scenes) {
    const SceneAccuracy accuracy = measure_accuracy(scene, backends, options, progress);
    progress.clear();
    json own = json::array();
    bool pictured = call.json.empty() || !have_images();
    for (const Judged& row : accuracy.rows) {
      own.push_back(to_json(scene, row));
      if (!pictured && row.method == "icm" && !row.field.x.empty()) {
        own.back()["differences"] = write_difference(scene, accuracy.truths, row, folder);
        pictured = true;
      }
    }
    fmt::print("\n{}, {} x {}: {}\n", scene.name, scene.extent().width, scene.extent().height, scene.title);
    print_published(scene);
    print_scene(accuracy, own);
    sound = is_sound(accuracy) && sound;
    std::fflush(stdout); // into a pipe too: the next scene may take long
    rows.insert(rows.end(), own.begin(), own.end());
  }
  call.write(std::move(rows), arguments.quick);
  return sound ? success : disagreement;
}

} // namespace

void add_accuracy(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "accuracy",
      "Measure every method against finite elements and the exact fixed point: Tables 5.1, 5.3, 5.5 and\n"
      "5.7 of the thesis by default, and a brain. Exit status 1 where a field is not scalar's to the bit or\n"
      "a step is not explained by rounding.",
      run_accuracy);
  own.schedule.takes_energy = true;
  own.add_to(command, call);
  remove_options(command, {"--method", "--methods", "--update", "--stop", "--epsilon"});
  add_option(command, "--repeat", own.repeats, "Samples of the seconds, fewer where they take long")
      ->check(CLI::Range(1, 1'000'000));
}

} // namespace hdmbench::commands
