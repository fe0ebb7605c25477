// The commands that judge methods against truths: accuracy, tradeoff and continuum.

#include "harness/cli/arguments.hpp"
#include "harness/judge/accuracy.hpp"
#include "harness/judge/tradeoff.hpp"
#include "harness/report/published.hpp"
#include "harness/scene/images/images.hpp"

#include <cstdio>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace hdmbench::commands {

namespace {

struct Arguments : CommonArguments {
  int repeats = 3;
  std::vector<std::string> at{"0.35px", "0.01px"}; ///< of tradeoff
};

/// "fem, nu 0.3", "icm on openmp", "icm: step set without 0".
std::string name_of(const Judged& row) {
  return fmt::format("{}{}{}", row.method,
                     row.poisson_used ? fmt::format(", nu {:.2g}", *row.poisson_used) : "",
                     !row.variant.empty()   ? ": " + row.variant
                     : !row.backend.empty() ? " on " + row.backend
                                            : "");
}

/// A table of rows as to_json() has them.
std::string judged_table(const json& rows) {
  return table_text(rows, "method|variant|poisson_used:nu|backend|effort|rmsd_to_fem:px to FEM|"
                          "rmsd_to_fem_nu0:FEM nu 0|rmsd_to_fixed_point:fixed point|"
                          "rmsd_interface_to_fem:interfaces|rmsd_elsewhere_to_fem:elsewhere|mean_energy|"
                          "iterations|fine_sweep_equivalents:fine sweeps|seconds_median:seconds|"
                          "asked:px asked|estimated_error:estimated|status");
}

/// What is not ok: a line for each status and reason.
std::string failures_text(const std::vector<Judged>& rows) {
  std::map<std::pair<JudgedStatus, std::string>, std::set<std::string>> failed;
  for (const Judged& row : rows) {
    if (row.status != JudgedStatus::ok) {
      failed[{row.status, row.reason}].insert(name_of(row));
    }
  }
  std::string text;
  for (const auto& [why, names] : failed) {
    text += fmt::format("  {}: {}: {}\n", hdmbench::name_of(why.first), joined(names, ", "), why.second);
  }
  return text;
}

void print_published(const Scene& scene) {
  for (const json& row : published()["accuracy"]) {
    if (row["scene"] == scene.name && scene.extent() == Extent{300, 300}) {
      constexpr std::string_view measured =
          "{rmsd} px to FEM, mean energy {mean_energy}, {iterations} iterations, ";
      fmt::print("{}{}{}", row_text("  thesis, table {table}: {method} ", row),
                 row.contains("rmsd") ? row_text(measured, row) : "", row_text("{seconds} s\n", row));
    }
  }
}

/// `rows`: as to_json() has them.
void print_scene(const SceneAccuracy& accuracy, const json& rows) {
  json fields = json::array();
  for (const json& row : rows) {
    if (!row["seconds"].empty()) {
      fields.push_back(row);
    }
  }
  fmt::print("{}{}", judged_table(fields), failures_text(accuracy.rows));
  for (const Judged& row : accuracy.rows) {
    if (row.variant.empty() && !row.note.empty()) {
      fmt::print("  {}: {}\n", name_of(row), row.note);
    }
  }
}

int run_accuracy(Arguments& arguments, Call& call) {
  const auto registry = make_backends();
  const std::vector<const Backend*> backends = arguments.choose(registry);
  const std::vector<Scene> scenes = arguments.load_scenes(
      {"square", "square-modified", "square-single-level", "circular", "circular-radial", "brain"});
  const auto is_of_cells = [](const Scene& scene) { return scene.energy->is_of_cells(); };
  if (arguments.schedule.options.iterations && std::ranges::any_of(scenes, is_of_cells)) {
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
      if (!pictured && row.method == "icm" && !row.field[0].empty()) {
        own.back()["differences"] = write_difference(scene, accuracy.truths, row, folder);
        pictured = true;
      }
    }
    fmt::print("\n{}, {}: {}\n", scene.name, size_text(scene.extent()), scene.title);
    print_published(scene);
    print_scene(accuracy, own);
    sound = sound && std::ranges::all_of(accuracy.rows, [](const Judged& row) {
              return row.status == JudgedStatus::ok || row.status == JudgedStatus::skipped;
            });
    std::fflush(stdout); // into a pipe too: the next scene may take long
    rows.insert(rows.end(), own.begin(), own.end());
  }
  call.write(std::move(rows), arguments.quick);
  return sound ? success : disagreement;
}

/// `equal`: as compare_at has it.
void print_equal_accuracy(const json& equal) {
  constexpr std::string_view at = "  At {target:.3g} px to FEM nu 0: ";
  const json& ours = equal["ours"];
  if (ours.is_null()) {
    if (!equal["nearest"].is_null()) {
      fmt::print("{}{}", row_text(at, equal),
                 row_text("no method is that near; the nearest is {nearest:.3g} px away.\n", equal));
    }
    return;
  }
  fmt::print("{}{}", row_text(at, equal),
             row_text("{method}, {effort} on {backend} is the fastest, {seconds_median:.3g} s;\n", ours));
  for (const auto& [key, title] : {std::pair("direct", "direct FEM"),
                                   {"iterative", "FEM by conjugate gradients"},
                                   {"multigrid", "FEM by multigrid of others"},
                                   {"coarse", "FEM on a coarse mesh"}}) {
    const json& rival = equal[key];
    fmt::print("    {} {}\n", title,
               rival.is_null()
                   ? "was not measured, or is nowhere that near."
                   : row_text("({effort}, {seconds_median:.3g} s) takes {ratio:.3g} times as long.", rival));
  }
}

/// The line that repeats a point: `run` solves by methods, this command by rivals.
std::string repeat(const Arguments& arguments, const Scene& scene, const Judged& row) {
  const std::string where =
      fmt::format("{} --size {}x{}", shell_word(scene.source), scene.extent().width, scene.extent().height);
  if (row.is_rival) {
    return fmt::format("hdmbench tradeoff {} --methods {}{}", where, row.method, arguments.schedule.text());
  }
  const std::string how = row.asked ? fmt::format("--energy elastic --accuracy {}px --explain", *row.asked)
                                    : fmt::format("--method {} --iterations {}", row.method, *row.told);
  return fmt::format("hdmbench run {} --backend {} {}{}{}", where, row.backend, how,
                     row.backend == "scalar" ? "" : arguments.session_words(), arguments.schedule.text());
}

int run_tradeoff(Arguments& arguments, Call& call) {
  std::vector<double> targets;
  std::ranges::transform(arguments.at, std::back_inserter(targets),
                         [](const std::string& text) { return parse_pixels(text); });
  // Among them rivals and requests, which load_scenes does not know.
  std::vector<std::string> methods = std::exchange(arguments.methods, {});
  if (methods == std::vector<std::string>{"all"}) {
    methods.clear();
  }
  const auto registry = make_backends();
  const std::vector<const Backend*> backends = arguments.choose(registry);
  Progress progress;
  json results = json::array();
  bool verified = true;
  fmt::print(
      "Seconds are medians of up to {} samples of a whole solution without set-up. RMSD to finite elements "
      "and to the\nfixed point over all sites, in pixels. Of the points: the front, and what was asked "
      "for.\n",
      arguments.quick ? 1 : arguments.repeats);
  std::vector<std::string> by_default{"square", "circular", "circular-radial", "brain"};
  by_default.resize(arguments.quick ? 1 : by_default.size());
  for (const Scene& scene : arguments.load_scenes(by_default)) {
    const TradeoffOptions options{.session = arguments.session,
                                  .repeats = arguments.repeats,
                                  .methods = methods,
                                  .quick = arguments.quick};
    const std::vector<Judged> rows = measure_tradeoff(scene, backends, options, progress);
    progress.clear();
    json shown = json::array();
    for (const Judged& row : rows) {
      results.push_back(to_json(scene, row));
      results.back()["kind"] = "point";
      results.back()["command"] = repeat(arguments, scene, row);
      verified = verified && row.status != JudgedStatus::unverified;
      if (!row.seconds.empty() && (row.is_on_front || row.asked)) {
        shown.push_back(results.back());
      }
    }
    std::ranges::sort(shown.get_ref<json::array_t&>(), {},
                      [](const json& row) { return row["seconds_median"].get<double>(); });
    fmt::print("\n{}, {}: {} points\n{}", scene.name, size_text(scene.extent()), rows.size(),
               judged_table(shown));
    for (const double target : targets) {
      print_equal_accuracy(results.emplace_back(compare_at(scene, rows, target)));
    }
    fmt::print("{}", failures_text(rows));
    std::fflush(stdout); // into a pipe too: the next scene may take long
  }
  call.write(std::move(results), arguments.quick);
  return verified ? success : disagreement;
}

struct ContinuumArguments {
  std::vector<int> sizes{50, 75, 100, 150, 200, 300, 400, 600};
  SceneArguments place; ///< backend and session
  bool quick = false;
};

/// Moduli of the inclusion over that around it.
constexpr std::array contrasts{0.1, 3.0, 10.0, 100.0};

int run_continuum(ContinuumArguments& arguments, Call& call) {
  if (arguments.quick) {
    arguments.sizes = {50, 100, 200};
  }
  std::ranges::sort(arguments.sizes);
  const auto registry = make_backends();
  const Backend& backend = find_backend(registry, arguments.place.backend);
  Progress progress;
  progress.set_total(contrasts.size() * std::inner_product(arguments.sizes.begin(), arguments.sizes.end(),
                                                           arguments.sizes.begin(), 0.0));
  json rows = json::array();
  for (const double contrast : contrasts) {
    const json more =
        measure_continuum(contrast, arguments.sizes, backend, arguments.place.session, progress);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  progress.clear();
  fmt::print(
      "A sheet with a round inclusion, stretched by 50 px, whose displacement is known in closed form. RMSD\n"
      "in pixels. Discretisation: finite elements on the pixels, direct and in double, from the closed "
      "form.\n"
      "Algebraic: our field at its usual effort from these finite elements; float32: when it rests. Order:\n"
      "of discretisation, since the first size.\n\n{}",
      table_text(rows, "contrast|size|discretisation.rmsd:discretisation|order|algebraic.rmsd:algebraic|"
                       "rounding.rmsd:float32|total.rmsd:our field in all|total.largest:largest"));
  call.write(std::move(rows), arguments.quick);
  return success;
}

} // namespace

void add_accuracy(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "accuracy",
      "Measure every method against finite elements and the exact fixed point: Tables 5.1, 5.3, 5.5 and\n"
      "5.7 of the thesis by default, and a brain. Exit status 1 where a field is not scalar's to the bit.",
      run_accuracy);
  own.schedule.takes_energy = true;
  own.add_to(command, call);
  remove_options(command, {"--method", "--methods", "--update", "--stop", "--epsilon"});
  add_option(command, "--repeat", own.repeats, "Samples of the seconds, fewer where they take long")
      ->check(CLI::Range(1, 1'000'000));
}

void add_tradeoff(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "tradeoff",
      "Speed against accuracy: every method at several efforts, and its rivals (finite elements direct, by\n"
      "conjugate gradients and on a coarse mesh, interpolation), timed and measured against the truths.\n"
      "Prints the Pareto front per scene; the report draws the chart. Exit status 1 where a field is not\n"
      "scalar's to the bit.",
      run_tradeoff);
  own.schedule.takes_energy = true;
  own.add_to(command, call);
  remove_options(command, {"--method", "--iterations", "--update", "--steps"});
  add_option(command, "--at", own.at, "Accuracies at which the fastest are compared: RMSD to FEM with nu 0")
      ->delimiter(',');
  add_option(command, "--repeat", own.repeats, "Samples per point, fewer where they take long")
      ->excludes("--quick")
      ->check(CLI::Range(1, 1'000'000));
}

void add_continuum(CLI::App& program, Call& call) {
  const auto [command, own] =
      declare(program, call, "continuum",
              "How far a mesh of pixels is from the continuum: a round inclusion whose displacement is "
              "known exactly,\non meshes of several sizes; errors of discretisation, of the solver and "
              "of float32 apart.",
              run_continuum);
  CLI::Option* const sizes =
      add_option(command, "--sizes", own.sizes, "Sides of the images, several with commas")
          ->delimiter(',')
          ->check(CLI::Range(8, 4096));
  own.place.add_backend_to(command);
  add_flag(command, "--quick", own.quick, "Three sizes to 200; the results say so")->excludes(sizes);
  add_json(command, call);
}

} // namespace hdmbench::commands
