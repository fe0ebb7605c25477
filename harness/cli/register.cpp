#include "harness/applications/picture.hpp"
#include "harness/applications/registration.hpp"
#include "harness/check/compare.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/registration/ways.hpp"
#include "harness/scene/images/images.hpp"

namespace hdmbench {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Similarity, mean_squares, correlation, mutual_information)
}

namespace hdmbench::commands {

namespace {

struct Arguments {
  PairArguments pair;
  bool iterate = false;
};

/// What a registration came to.
struct Outcome {
  VectorField displacement;
  VectorField confidence; ///< of Algorithm 5
  json row;               ///< as it stands in the result file
};

ScalarField difference_of(const ScalarField& a, const ScalarField& b) {
  ScalarField result(a.extent);
  std::ranges::transform(a.values, b.values, result.values.begin(), std::minus<>());
  return result;
}

/// Squares of one picture and of the other in turn: where edges go on across them the two match.
ScalarField checkerboard(const ScalarField& a, const ScalarField& b) {
  ScalarField board(a.extent);
  const int side = std::max(8, a.extent.width / 8);
  for_each_site(a.extent, [&](int x, int y) {
    const std::size_t site = a.extent.index(x, y);
    board.values[site] = (x / side + y / side) % 2 == 0 ? a.values[site] : b.values[site];
  });
  return board;
}

/// All that write_files may write.
std::vector<std::string> output_files() {
  std::vector<std::string> files{"displacement.nrrd"};
  for (const char* const picture :
       {"source", "target", "warped", "checkerboard-before", "checkerboard-after", "grid",
        "difference-before", "difference-after", "jacobian", "confidence"}) {
    files.push_back(fmt::format("{}.png", picture));
  }
  return files;
}

void write_files(const PairArguments& arguments, const Call& call, const PictureData& data,
                 Outcome& outcome) {
  const Extent extent = data.source.extent;
  const ScalarField warped = warp(data.source, outcome.displacement);
  Pictures pictures(arguments.output, call.json);
  pictures.gray("source", "source", data.source);
  pictures.gray("target", "target", data.target);
  pictures.gray("warped", "source, moved to the target", warped);
  pictures.gray("checkerboard-before", "source and target in turn, before",
                checkerboard(data.source, data.target));
  pictures.gray("checkerboard-after", "the same, after", checkerboard(warped, data.target));
  pictures.gray("grid", "grid, deformed",
                warp(grid_picture(extent, grid_spacing(extent)), outcome.displacement));
  constexpr double largest_difference = 128.0; // gray values
  pictures.signed_values("difference-before", "target minus source: red brighter, blue darker",
                         difference_of(data.target, data.source), largest_difference);
  pictures.signed_values("difference-after", "the same, after", difference_of(data.target, warped),
                         largest_difference);
  pictures.signed_values("jacobian", "change of area: blue smaller (full: a fold), red larger",
                         area_change_map(outcome.displacement), 1.0);
  if (!outcome.confidence[0].empty()) {
    ScalarField believed(extent);
    std::ranges::transform(outcome.confidence[0], outcome.confidence[1], believed.values.begin(),
                           [](float x, float y) { return 255.0F * (x + y); });
    pictures.gray("confidence", "where the registration is believed: white most", believed);
  }
  outcome.row["pictures"] = pictures.written();
  write_displacement(arguments.output / "displacement.nrrd", outcome.displacement, data.scene.spacing,
                     data.placement);
  outcome.row["field"] = beside(call.json, arguments.output, "displacement.nrrd");
}

Outcome register_region(const Arguments& arguments, const PictureData& data, const Backend& backend,
                        Progress& progress) {
  progress.describe("register: ITK's B-splines");
  const ConventionalRegistration first =
      register_conventionally(data.source, data.target, data.region, progress);
  Outcome outcome;
  progress.describe(fmt::format("register: {} on {}", data.scene.name, backend.name()));
  Solution solution = make_physical(data.source, data.target, first.displacement, data.region, data.scene,
                                    backend, arguments.pair.scene.session, outcome.confidence, progress);
  outcome.displacement = std::move(solution.displacement);
  outcome.row = {{"conventional_seconds", first.seconds},
                 {"seconds", first.seconds + solution.timings.total()},
                 {"energy", data.scene.energy->name}};
  return outcome;
}

Outcome register_iterated(const Arguments& arguments, const PictureData& data, const Backend& backend,
                          Progress& progress) {
  const auto session = backend.open_elastic(arguments.pair.scene.session);
  if (session == nullptr) {
    throw InputError(fmt::format("{} has no elastic energy, which --iterate solves with", backend.name()));
  }
  IteratedRegistration found =
      register_iteratively(data.source, data.target, data.scene, data.region, {}, *session, progress);
  Outcome outcome;
  outcome.row = {{"converged", found.converged},
                 {"seconds", found.seconds},
                 {"energy", energy_near(ReferenceSolution::finite_elements).name},
                 {"iterations", json::array()}};
  for (const RegistrationIteration& iteration : found.iterations) {
    outcome.row["iterations"].push_back({{"level", iteration.level},
                                         {"width", iteration.extent.width},
                                         {"height", iteration.extent.height},
                                         {"difference", iteration.difference},
                                         {"outliers", iteration.outliers},
                                         {"step", iteration.step}});
  }
  outcome.displacement = std::move(found.displacement);
  return outcome;
}

int run_register(Arguments& arguments, Call& call) {
  const ScheduleOverrides& schedule = arguments.pair.scene.schedule;
  if (arguments.iterate) {
    const bool is_idle = schedule.energy != nullptr && !schedule.energy->is_of_cells();
    refuse_idle(*call.command, schedule_options(*call.command, {is_idle ? "" : "--energy"}),
                "--iterate looks at the pictures itself, and solves the elastic energy its way");
  }
  const PictureData data = arguments.pair.load();
  const Schedule& solved = data.scene.schedule;
  const bool has_sweeps_only = !data.scene.energy->is_of_cells() || solved.method == elastic_sweeps;
  if (!arguments.iterate && has_sweeps_only && solved.iterations == 0) {
    throw InputError("register with 0 iterations would leave everything where it is; give at least 1");
  }
  const auto registry = make_backends();
  const Backend& backend = arguments.pair.scene.choose(registry, data.scene);
  const Device device = backend.device(arguments.pair.scene.session);
  arguments.pair.require_output(output_files());
  Progress progress;
  Outcome outcome = arguments.iterate ? register_iterated(arguments, data, backend, progress)
                                      : register_region(arguments, data, backend, progress);
  progress.clear();
  const Similarity before = similarity(data.source, data.target);
  const Similarity after = similarity(data.source, pulled_back(data.target, outcome.displacement));
  const Warnings warnings = diagnose(data.source, data.target, before, after);
  const ScalarField areas = least_area_ratios(outcome.displacement);
  const auto folds = std::ranges::count_if(areas.values, [](float ratio) { return !(ratio > 0.0F); });
  const bool converged = outcome.row.value("converged", true);
  json& row = outcome.row;
  row.update(row_of(data.scene));
  row.update({{"spacing", data.scene.spacing},
              {"placement", data.placement},
              {"algorithm", arguments.iterate ? "iterated" : "region"},
              {"backend", backend.name()},
              {"device", device.name},
              {"before", before},
              {"after", after},
              {"folds", folds},
              {"largest_displacement", largest_magnitude(outcome.displacement)}});
  if (!warnings.empty()) {
    row["warnings"] = warnings;
  }
  write_files(arguments.pair, call, data, outcome);

  fmt::print("{}, {} pixels of {:.4g} mm, {} energy on {} ({})\n\n", data.scene.title,
             size_text(data.scene.extent()), data.scene.spacing, row["energy"].get<std::string>(),
             backend.name(), device.name);
  if (arguments.iterate) {
    fmt::print("{}\n  {}\n\n", table_text(row["iterations"], "size|difference|outliers|step:step, px"),
               converged ? "Converged: the last step moved nothing by more than its tolerance."
                         : "Not converged: the last step still moved the tissue; look at the differences.");
  }
  json measures = json::array();
  for (const auto& [key, what] : {std::pair{"mean_squares", "mean squared difference"},
                                  {"correlation", "correlation"},
                                  {"mutual_information", "mutual information, bits"}}) {
    measures.push_back({{"what", what}, {"before", row["before"][key]}, {"after", row["after"][key]}});
  }
  fmt::print(
      "{}{}{}\n", table_text(measures, "what:|before|after"),
      row_text(
          "\n  largest displacement {largest_displacement:.4g} px, {folds} folded cells, {seconds:.3g} s",
          row),
      arguments.iterate ? "" : row_text(" ({conventional_seconds:.3g} of them ITK's)", row));
  fmt::print("  {}: the displacement in millimetres; beside it {} pictures\n",
             (arguments.pair.output / "displacement.nrrd").string(), row["pictures"].size());
  if (!warnings.empty()) {
    fmt::print("\n{}", warnings_text(warnings));
  }
  call.write(json::array({without_nulls(row)}));
  return !contains(warnings, no_likeness, &Warning::kind) && converged ? success : disagreement;
}

} // namespace

void add_register(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "register",
      "Find the displacement between two pictures of one person, with the tissues' moduli (thesis "
      "Algorithms 5 and 6).\nWrites DIR/displacement.nrrd and pictures before and after. Exit status 1 where "
      "the pictures have no likeness.",
      run_register);
  own.pair.add_to(command, call, false);
  add_flag(command, "--iterate", own.iterate,
           "No ITK: estimate, solve with the elastic energy and look again, from coarse to fine; "
           "exit status 1 where it does not converge");
}

} // namespace hdmbench::commands
