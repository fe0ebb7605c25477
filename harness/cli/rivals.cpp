#include "backends/shared/elastic_session.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/judge/registration/elastix.hpp"
#include "harness/judge/registration/knobs.hpp"
#include "harness/measure/median.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/images/images.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;

struct Arguments {
  SceneArguments scene;
  std::vector<std::string> kinds{planted_names.begin(), planted_names.end()};
  std::vector<double> amplitudes{10.0};
  std::vector<double> noises{0.03};
  std::vector<std::uint32_t> seeds{1};
  bool quick = false;
  int knobs = 0;     ///< cases of each value; 0: registration
  int detection = 0; ///< pairs of cases; 0: registration
  double radius = 8.0;
  double contrast = 3.0;
  std::optional<double> detection_noise;
  bool pictures = false;
  bool spread = false;
  std::string other; ///< scene; empty: the pair is planted
  fs::path output;
  fs::path json;
};

/// For `register` and `detect`.
void write_pair(const fs::path& folder, const Scene& scene, const PlantedPair& pair, std::string_view what) {
  const std::vector<std::string> files{"source.nrrd", "target.nrrd", "region.nrrd", "truth.nrrd"};
  require_folder(folder, files, files_of_scene(scene.source));
  write_scalar(folder / "source.nrrd", pair.source, scene.spacing, scene.placement);
  write_scalar(folder / "target.nrrd", pair.target, scene.spacing, scene.placement);
  write_scalar(folder / "region.nrrd", pair.region, scene.spacing, scene.placement);
  write_vector(folder / "truth.nrrd", pair.truth, scene.spacing, scene.placement);
  fmt::print("  {}: source, target, region and truth (pixels) of {}\n\n", folder.string(), what);
}

void print_rows(const std::vector<RivalRow>& rows) {
  const RivalRow& first = rows.front();
  fmt::print("{}, {} x {}: {} of {:g} px, noise {:g} %, seed {}; RMSD to the truth in pixels\n\n",
             first.scene, first.width, first.height, first.planted, first.amplitude, 100.0 * first.noise,
             first.seed);
  Table table({"method", "tissue", "95 %", "region", "Dice", "folds", "s"});
  for (const RivalRow& row : rows) {
    table.add({row.method, fmt::format("{:.3f}", row.tissue), fmt::format("{:.3f}", row.tissue_95),
               fmt::format("{:.3f}", row.region), fmt::format("{:.3f}", row.dice), std::to_string(row.folds),
               fmt::format("{:.2f}", row.seconds)});
  }
  fmt::print("{}\n", table.text());
}

void say_what_is_missing(const Arguments& arguments) {
  if (!arguments.quick && !is_installed("elastix")) {
    fmt::print("{} was not compared: there is no elastix on PATH (Debian's package elastix)\n", by_elastix);
  }
}

int compare(const Arguments& arguments, const Scene& scene, const Backend& backend, Progress& progress,
            const std::string& line) {
  nlohmann::json results = nlohmann::json::array();
  for (const std::string& name : arguments.kinds) {
    for (const double amplitude : arguments.amplitudes) {
      for (const double noise : arguments.noises) {
        for (const std::uint32_t seed : arguments.seeds) {
          const PlantedOptions options{
              .kind = static_cast<Planted>(std::ranges::find(planted_names, name) - planted_names.begin()),
              .amplitude = amplitude,
              .noise = noise,
              .seed = seed};
          if (!arguments.output.empty()) {
            write_pair(arguments.output / name, scene, plant(scene, options), name);
          }
          const std::vector<RivalRow> rows =
              compare_rivals(scene, options, !arguments.quick, backend, arguments.scene.session, progress);
          progress.clear();
          print_rows(rows);
          for (const RivalRow& row : rows) {
            results.push_back(to_json_row(row));
          }
        }
      }
    }
  }
  say_what_is_missing(arguments);
  write_results(arguments.json, "rivals", run_context(line, arguments.quick), std::move(results));
  return success;
}

/// Their labels mean the same tissues, or nothing is said.
int compare_people(const Arguments& arguments, const Scene& scene, const Backend& backend, Progress& progress,
                   const std::string& line) {
  SceneArguments other = arguments.scene;
  other.scene = arguments.other;
  const std::vector<PeopleRow> rows = hdmbench::compare_people(scene, other.load(), !arguments.quick, backend,
                                                               arguments.scene.session, progress);
  progress.clear();
  fmt::print("{} to {}, {} x {}: overlap of the labels (Dice)\n\n", rows.front().scene, rows.front().other,
             rows.front().width, rows.front().height);
  std::vector<Table::Column> head{"method", "labels, mean"};
  for (const PeopleRow::Overlap& overlap : rows.front().overlaps) {
    head.emplace_back(fmt::format("label {}", overlap.label));
  }
  head.insert(head.end(), {"correlation", "folds", "s"});
  Table table(head);
  nlohmann::json results = nlohmann::json::array();
  for (const PeopleRow& row : rows) {
    std::vector<std::string> cells{row.method, fmt::format("{:.3f}", row.dice)};
    for (const PeopleRow::Overlap& overlap : row.overlaps) {
      cells.push_back(fmt::format("{:.3f}", overlap.dice));
    }
    cells.insert(cells.end(), {fmt::format("{:.3f}", row.correlation), std::to_string(row.folds),
                               fmt::format("{:.2f}", row.seconds)});
    table.add(cells);
    results.push_back(to_json_row(row));
  }
  fmt::print("{}\n", table.text());
  say_what_is_missing(arguments);
  write_results(arguments.json, "people", run_context(line, arguments.quick), std::move(results));
  return success;
}

int look(const Arguments& arguments, const Scene& scene, const Backend& backend, Progress& progress,
         const std::string& line) {
  const auto session = backend.open_elastic(arguments.scene.session);
  progress.set_total(2.0 * arguments.detection);
  progress.describe(fmt::format("rivals {}: planted inclusions", scene.name));
  std::vector<InclusionRow> rows;
  std::vector<double> distances;
  std::vector<double> contrasts;
  std::vector<double> seconds;
  const double noise = arguments.detection_noise.value_or(arguments.pictures ? PlantedOptions{}.noise
                                                                             : PlantedInclusion{}.noise);
  for (int number = 0; number < arguments.detection; ++number) {
    const auto seed = arguments.seeds.front() + static_cast<std::uint32_t>(number);
    PlantedInclusion inclusion =
        arguments.spread
            ? any_inclusion(seed)
            : PlantedInclusion{.radius = arguments.radius, .contrast = arguments.contrast, .seed = seed};
    inclusion.noise = noise;
    if (number == 0 && arguments.pictures && !arguments.output.empty()) {
      PlantedInclusion exact = inclusion;
      exact.noise = 0.0;
      const PlantedField field = plant(scene, exact);
      write_pair(arguments.output / "inclusion", scene, pictures_of(scene, field, noise, seed),
                 fmt::format("an inclusion at x = {:.1f}, y = {:.1f}", field.x, field.y));
    }
    for (const double contrast : {inclusion.contrast, 1.0}) {
      inclusion.contrast = contrast;
      rows.push_back(look_for(scene, scene, inclusion, arguments.pictures, *session, progress));
      rows.back().spread = arguments.spread;
      seconds.push_back(rows.back().seconds);
      if (contrast != 1.0) {
        distances.push_back(rows.back().distance);
        contrasts.push_back(rows.back().found_contrast / contrast);
      }
    }
  }
  progress.clear();
  fmt::print("{}, {} x {}: {} cases with an inclusion of {}, as many without; noise {:g} % of {}\n\n",
             scene.name, scene.extent().width, scene.extent().height, arguments.detection,
             arguments.spread
                 ? "radius 3 to 15 px and contrast 1.5 to 10"
                 : fmt::format("radius {:g} px and contrast {:g}", arguments.radius, arguments.contrast),
             100.0 * noise, arguments.pictures ? "white, in the pictures" : "the largest displacement");
  const auto more_than_chance = [&](bool hidden) {
    return std::ranges::count_if(rows, [&](const InclusionRow& row) {
      return (row.contrast != 1.0) == hidden && row.score > row.by_chance;
    });
  };
  Table table({"", ""});
  table.add({"area under the ROC", fmt::format("{:.3f}", area_under_roc(rows).value_or(0.0))});
  table.add({"the same, had the place been known",
             fmt::format("{:.3f}", area_under_roc(rows, &InclusionRow::place_score).value_or(0.0))});
  table.add({"more than chance, with an inclusion",
             fmt::format("{} of {}", more_than_chance(true), arguments.detection)});
  table.add(
      {"more than chance, without", fmt::format("{} of {}", more_than_chance(false), arguments.detection)});
  table.add({"error of the position, median", fmt::format("{:.2f} px", median(distances))});
  table.add({"contrast found over the true one, median", fmt::format("{:.2f}", median(contrasts))});
  table.add({"seconds, median", fmt::format("{:.2f}", median(seconds))});
  fmt::print("{}", table.text());
  nlohmann::json results = nlohmann::json::array();
  for (const InclusionRow& row : rows) {
    results.push_back(to_json_row(row));
  }
  write_results(arguments.json, "roc", run_context(line, arguments.quick), std::move(results));
  return success;
}

int turn(const Arguments& arguments, const Scene& scene, const Backend& backend, Progress& progress,
         const std::string& line) {
  const std::vector<KnobRow> rows =
      turn_knobs(scene, arguments.knobs, !arguments.quick, backend, arguments.scene.session, progress);
  progress.clear();
  Table physical({"knob", "value", "tissue", "region", "b-splines", "believed", "folded"});
  Table iterated({"knob", "value", "tissue", "region", "outliers", "not converged", "folded"});
  Table detected({"knob", "value", "area under the ROC", "found", "warned", "where nothing is", "warned",
                  "position, px"});
  nlohmann::json results = nlohmann::json::array();
  for (const KnobRow& row : rows) {
    const std::string value = fmt::format("{:g}", row.value);
    if (row.conventional) {
      physical.add({row.knob, value, fmt::format("{:.3f}", *row.tissue), fmt::format("{:.3f}", *row.region),
                    fmt::format("{:.3f}", *row.conventional), fmt::format("{:.1f} %", 100.0 * *row.believed),
                    std::to_string(*row.folded)});
    } else if (row.tissue) {
      iterated.add({row.knob, value, fmt::format("{:.3f}", *row.tissue), fmt::format("{:.3f}", *row.region),
                    fmt::format("{:.1f} %", 100.0 * *row.outliers), std::to_string(*row.not_converged),
                    std::to_string(*row.folded)});
    } else {
      detected.add({row.knob, value, fmt::format("{:.3f}", row.area.value_or(0.5)),
                    fmt::format("{} of {}", *row.found, row.cases), std::to_string(*row.warned),
                    fmt::format("{} of {}", *row.mistaken, row.cases), std::to_string(*row.mistaken_warned),
                    fmt::format("{:.2f}", *row.distance)});
    }
    results.push_back(to_json_row(row));
  }
  fmt::print("{}, {} x {}: {} cases of each value\n\n", scene.name, scene.extent().width,
             scene.extent().height, arguments.knobs);
  if (!arguments.quick) {
    fmt::print(
        "Algorithm 5, a resection: error in pixels, that of ITK's B-splines in the region, and how much of "
        "them was believed\n\n{}\n",
        physical.text());
  }
  fmt::print("Algorithm 6, a resection: error in pixels, what warns\n\n{}\nAlgorithm 7: inclusions in a "
             "displacement, more than chance found; warned: the picture shows another tissue there\n\n{}",
             iterated.text(), detected.text());
  write_results(arguments.json, "knobs", run_context(line, arguments.quick), std::move(results));
  return success;
}

/// Of the four things that rivals does each has options of its own.
void require_meaning(const Arguments& arguments, const Command& command) {
  const bool turns = arguments.knobs > 0;
  const bool compares = !turns && arguments.other.empty() && arguments.detection == 0;
  const bool detects = !turns && arguments.other.empty() && arguments.detection > 0;
  refuse_idle(
      command,
      {{.here = turns, .options = {"--other", "--detection"}, .why = "--knobs plants what it needs itself"},
       {.here = !arguments.other.empty(),
        .options = {"--detection"},
        .why = "with --other nothing is planted"},
       {.here = !compares,
        .options = {"--planted", "--amplitudes", "--noises"},
        .why = "only planted deformations take that, without --knobs, --other and --detection"},
       {.here = !compares && !detects,
        .options = {"--seeds"},
        .why = "only planted deformations and inclusions take that, without --knobs and --other"},
       {.here = !compares && !(detects && arguments.pictures),
        .options = {"--output"},
        .why = "only pictures of planted deformations are written; with --detection give --pictures"},
       {.here = detects, .options = {"--quick"}, .why = "--detection has no mutual information to leave out"},
       {.here = !detects,
        .options = {"--radius", "--contrast", "--spread", "--pictures", "--field-noise"},
        .why = "only --detection takes that"},
       {.here = arguments.spread,
        .options = {"--radius", "--contrast"},
        .why = "--spread takes another one in each case"}});
}

int run_rivals(const Arguments& arguments, const Command& command, const std::string& line) {
  require_meaning(arguments, command);
  if (arguments.detection < 0 || arguments.seeds.empty()) {
    throw InputError("rivals: the number of cases must not be negative, and one seed is needed");
  }
  const Scene scene = arguments.scene.load();
  const auto registry = make_backends();
  const Backend& backend = arguments.scene.choose(registry, scene);
  if (!backend.has_elastic()) {
    throw InputError(fmt::format("{} has no elastic energy", backend.name()));
  }
  require_results_writable(arguments.json);
  Progress progress;
  if (arguments.knobs > 0) {
    return turn(arguments, scene, backend, progress, line);
  }
  if (!arguments.other.empty()) {
    return compare_people(arguments, scene, backend, progress, line);
  }
  return arguments.detection > 0 ? look(arguments, scene, backend, progress, line)
                                 : compare(arguments, scene, backend, progress, line);
}

} // namespace

void add_rivals(const Command& program, const std::string& arguments, int& status) {
  const Command command = program.add_subcommand(
      "rivals", "register and detect against planted truth, and what others do: finite elements deform a "
                "slice,\nnoise is added, and every method has to find out how.");
  const auto own = std::make_shared<Arguments>();
  own->scene.scene = "brain";
  own->scene.schedule.takes_elastic = true;
  command.add_option("scene", own->scene.scene, "Scene by name or TOML file").capture_default_str();
  command.add_option("--size", own->scene.size, "Image size: 300 (square) or 257x130");
  own->scene.add_orientation_to(command);
  own->scene.add_backend_to(command);
  command.add_option("--planted", own->kinds, "What deforms: growth, resection, pressure, with commas")
      .delimiter(',')
      .one_of(std::vector<std::string>(planted_names.begin(), planted_names.end()));
  command.add_option("--amplitudes", own->amplitudes, "Largest displacement, pixels, several with commas")
      .delimiter(',')
      .range(0.0, 100.0)
      .capture_default_str();
  command.add_option("--noises", own->noises, "In the pictures, share of white, several with commas")
      .delimiter(',')
      .range(0.0, 1.0)
      .capture_default_str();
  command.add_option("--seeds", own->seeds, "Of place, direction and noise, several with commas")
      .delimiter(',')
      .capture_default_str();
  command.add_flag("--quick", own->quick,
                   "Without mutual information: ITK's, elastix's, and so without Algorithm 5");
  command.add_option(
      "--other", own->other,
      "Nothing is planted: register to the picture of this scene, another person of whom a label "
      "is the same tissue");
  command.add_option(
      "--output", own->output,
      "Write the pictures of each pair to this folder, for register; with --pictures those of the "
      "first inclusion, for detect");
  command
      .add_option(
          "--knobs", own->knobs,
          "Where Algorithms 5, 6 and 7 break: noise, sizes, contrast, wrong moduli and labels, so many "
          "cases of each value")
      .range(1, 1000);
  const auto* const group = "Detection";
  command
      .add_option("--detection", own->detection, "So many cases with a hidden inclusion, and as many without")
      .group(group);
  command.add_option("--radius", own->radius, "Of inclusions, pixels")
      .range(1.0, 100.0)
      .group(group)
      .capture_default_str();
  command.add_option("--contrast", own->contrast, "Their modulus over the label's")
      .range(0.01, 100.0)
      .group(group)
      .capture_default_str();
  command.add_flag("--spread", own->spread, "Radius 3 to 15 pixels and contrast 1.5 to 10, another each case")
      .group(group);
  command
      .add_flag("--pictures", own->pictures,
                "The displacement is not given: Algorithm 6 finds it in pictures that do not show the "
                "inclusion")
      .group(group);
  command
      .add_option(
          "--field-noise", own->detection_noise,
          "Of the observed displacement, share of the largest one: 0.01; of pictures, share of white: "
          "0.03")
      .range(0.0, 1.0)
      .group(group);
  command.add_option("--json", own->json, "Write the results to this file");
  command.callback([own, command, arguments, &status] { status = run_rivals(*own, command, arguments); });
}

} // namespace hdmbench::commands
