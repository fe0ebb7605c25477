// The commands that compare two pictures: register and detect.

#include "harness/applications/detection.hpp"
#include "harness/applications/picture.hpp"
#include "harness/applications/registration.hpp"
#include "harness/check/compare.hpp"
#include "harness/cli/picture_pair.hpp"
#include "harness/cli/run_files.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/registration/ways.hpp"
#include "harness/scene/row_fields.hpp"

#include <cmath>

namespace hdmbench {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Detection, noise, unexplained_before, unexplained, largest, x, y, radius,
                                   contrast, position_deviation, contrast_deviation)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Similarity, mean_squares, correlation, mutual_information)
} // namespace hdmbench

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;

const Option<bool> iterate("--iterate", "No ITK: estimate, solve with the elastic energy and look again, "
                                        "from coarse to fine; exit status 1 where it does not converge");

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

void write_files(const Call& call, const PictureData& data, Outcome& outcome) {
  const VectorField& displacement = outcome.displacement;
  const ScalarField tissue = tissue_of(data.scene);
  const std::vector<Plane> planes = planes_to_show(magnitude_of(displacement, tissue));
  const auto drawn = [&](const auto& draw) { return drawn_beside(planes, data.scene.full.sides, draw); };
  const auto slices_of = [&](const ScalarField& field) {
    return drawn([&](const Plane& plane) { return slice_of(field, plane); });
  };
  const ScalarField source = slices_of(data.source);
  const ScalarField target = slices_of(data.target);
  const ScalarField warped =
      drawn([&](const Plane& plane) { return warp(data.source, displacement, plane); });
  // Grey, or red above 0 and blue below, full at `largest`.
  const auto gray = [&](const char* name, const char* caption, const ScalarField& picture) {
    write_png(picture_file(outcome.row, call, name, caption), picture);
  };
  const auto signed_values = [&](const char* name, const char* caption, const ScalarField& values,
                                 double largest) {
    write_signed_png(picture_file(outcome.row, call, name, caption), values.extent, values.values, largest);
  };
  gray("source", "source", source);
  gray("target", "target", target);
  gray("warped", "source, moved to the target", warped);
  gray("checkerboard-before", "source and target in turn, before", checkerboard(source, target));
  gray("checkerboard-after", "the same, after", checkerboard(warped, target));
  gray("grid", "grid, deformed", drawn([&](const Plane& plane) { return warped_grid(displacement, plane); }));
  constexpr double largest_difference = 128.0; // gray values
  signed_values("difference-before", "target minus source: red brighter, blue darker",
                difference_of(target, source), largest_difference);
  signed_values("difference-after", "the same, after", difference_of(target, warped), largest_difference);
  signed_values("jacobian", "change of area or volume: blue smaller (full: a fold), red larger",
                drawn([&](const Plane& plane) { return content_change(displacement, plane, tissue); }), 1.0);
  if (!outcome.confidence[0].empty()) {
    ScalarField believed(data.source.extent);
    std::ranges::transform(outcome.confidence[0], outcome.confidence[1], believed.values.begin(),
                           [](float x, float y) { return 255.0F * (x + y); });
    gray("confidence", "where the registration is believed: white most", believed);
  }
  write_displacement(call[option::output] / "displacement.nrrd", outcome.displacement, data.scene.spacing,
                     data.placement);
  outcome.row["field"] = beside(call[option::json], call[option::output], "displacement.nrrd");
}

Outcome register_region(const Call& call, const PictureData& data, const Backend& backend,
                        Progress& progress) {
  progress.describe("register: ITK's B-splines");
  const ConventionalRegistration first =
      register_conventionally(data.source, data.target, data.region, progress);
  Outcome outcome;
  progress.describe(fmt::format("register: {} on {}", data.scene.name, backend.name()));
  Solution solution = make_physical(data.source, data.target, first.displacement, data.region, data.scene,
                                    backend, call.session(), outcome.confidence, progress);
  outcome.displacement = std::move(solution.displacement);
  outcome.row = {{"conventional_seconds", first.seconds},
                 {"seconds", first.seconds + solution.timings.total()},
                 {"energy", data.scene.energy->name}};
  return outcome;
}

Outcome register_iterated(const Call& call, const PictureData& data, const Backend& backend,
                          Progress& progress) {
  const auto session = backend.open_elastic(call.session());
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
    outcome.row["iterations"].push_back(with_size({{"level", iteration.level},
                                                   {"difference", iteration.difference},
                                                   {"outliers", iteration.outliers},
                                                   {"step", iteration.step}},
                                                  iteration.extent));
  }
  outcome.displacement = std::move(found.displacement);
  return outcome;
}

/// `on`: the backend and its device.
void print_register(const Call& call, const PictureData& data, const std::string& on, const json& row,
                    const Warnings& warnings) {
  fmt::print("{}, {} {} of {:.4g} mm, {} energy on {}\n\n", data.scene.title, data.scene.extent().text(),
             data.scene.extent().axes() == 3 ? "voxels" : "pixels", data.scene.spacing,
             row["energy"].get<std::string>(), on);
  if (call[iterate]) {
    fmt::print("{}\n  {}\n\n", table_text(row["iterations"], "size|difference|outliers|step:step, px"),
               row.value("converged", true)
                   ? "Converged: the last step moved nothing by more than its tolerance."
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
      call[iterate] ? "" : row_text(" ({conventional_seconds:.3g} of them ITK's)", row));
  fmt::print("  {}: the displacement in millimetres; beside it {} pictures\n",
             (call[option::output] / "displacement.nrrd").string(), row["pictures"].size());
  if (!warnings.empty()) {
    fmt::print("\n{}", warnings_text(warnings));
  }
}

int run_register(Call& call) {
  if (call[iterate]) {
    const bool is_idle = call.schedule.energy != nullptr && !call.schedule.energy->is_of_cells();
    refuse_idle(*call.command, schedule_names(*call.command, {is_idle ? "" : "--energy"}),
                "--iterate looks at the pictures itself, and solves the elastic energy its way");
  }
  const PictureData data = load_pictures(call);
  const Schedule& solved = data.scene.schedule;
  const bool has_sweeps_only = !data.scene.energy->is_of_cells() || solved.method == elastic_sweeps;
  if (!call[iterate] && has_sweeps_only && solved.iterations == 0) {
    throw InputError("register with 0 iterations would leave everything where it is; give at least 1");
  }
  const auto registry = make_backends();
  const Backend& backend = choose_backend(call, registry, data.scene);
  const Device device = backend.device(call.session());
  require_output(call, output_files());
  Progress progress;
  Outcome outcome = call[iterate] ? register_iterated(call, data, backend, progress)
                                  : register_region(call, data, backend, progress);
  progress.clear();
  const Similarity before = similarity(data.source, data.target);
  const Similarity after = similarity(data.source, pulled_back(data.target, outcome.displacement));
  Warnings warnings = diagnose(data.source, data.target, before, after);
  const ScalarField tissue = tissue_of(data.scene);
  std::ranges::move(diagnose(outcome.displacement, tissue), std::back_inserter(warnings));
  const ScalarField areas = least_area_ratios(outcome.displacement, tissue);
  const auto folds = std::ranges::count_if(areas.values, [](float ratio) { return !(ratio > 0.0F); });
  const bool converged = outcome.row.value("converged", true);
  json& row = outcome.row;
  row.update(row_of(data.scene));
  row.update({{"spacing", data.scene.spacing},
              {"placement", data.placement},
              {"algorithm", call[iterate] ? "iterated" : "region"},
              {"backend", backend.name()},
              {"device", device.name},
              {"before", before},
              {"after", after},
              {"folds", folds},
              {"largest_displacement", largest_magnitude(outcome.displacement, tissue)}});
  if (!warnings.empty()) {
    row["warnings"] = warnings;
  }
  write_files(call, data, outcome);

  print_register(call, data, fmt::format("{} ({})", backend.name(), device.name), row, warnings);
  call.write(json::array({without_nulls(row)}));
  const bool is_of_use =
      std::ranges::none_of(std::array{no_likeness, worse_than_nothing, fold_over},
                           [&](auto kind) { return contains(warnings, kind, &Warning::kind); });
  return is_of_use && converged ? success : disagreement;
}

/// Any contrast that the search tries explains as much.
bool is_undetermined(const Detection& found) {
  return !(found.contrast_deviation < largest_logarithm);
}

/// The search ended at its limit: it may be more.
bool is_at_limit(const Detection& found) {
  return std::abs(std::log(found.contrast)) > 0.999 * largest_logarithm;
}

/// How much stiffer or softer, as far as the search can tell. Without an interval: the error of a
/// registration is a bias, of which no deviation by noise knows.
std::string contrast_text(const Detection& found) {
  const double most = std::exp(largest_logarithm);
  if (is_undetermined(found)) {
    return fmt::format("any modulus from 1/{0:.0f} to {0:.0f} times the label's: it cannot be told", most);
  }
  return is_at_limit(found) ? fmt::format("{} the label's modulus, where the search ends",
                                          found.contrast > 1.0 ? fmt::format("{:.0f} times or more", most)
                                                               : fmt::format("1/{:.0f} or less of", most))
                            : fmt::format("about {:.2g} times the label's modulus", found.contrast);
}

std::string verdict(bool chance_found_it, const Detection& found) {
  if (chance_found_it) {
    return "Nothing that chance does not find as well.";
  }
  return is_undetermined(found) ? "More than chance is unexplained, but not by stiffer or softer tissue: "
                                  "the deformation does not tell its modulus."
                                : "More than chance found: tissue there is not as its label says.";
}

constexpr double strong = 4.0; // standard deviations that are full colour

const Option<int> simulations(
    "--simulations",
    "Pairs of pictures with nothing hidden that are registered too: what is found in them is chance",
    DetectionOptions{}.pairs, CLI::Range(3, 1000));

int run_detect(Call& call) {
  const PictureData data = load_pictures(call);
  if (data.scene.extent().axes() == 3) {
    throw InputError("detect takes images only: cut a slice");
  }
  const auto registry = make_backends();
  const Backend& backend = choose_backend(call, registry, data.scene);
  const Device device = backend.device(call.session());
  require_output(call,
                 std::vector<std::string>{"modulus.nrrd", "detection.nrrd", "source.png", "detection.png"});
  const auto session = backend.open_elastic(call.session());
  if (session == nullptr) {
    throw InputError(fmt::format("{} has no elastic energy, which detect solves with", backend.name()));
  }
  Progress progress;
  // The pictures are looked at inside the region too: it is the modulus there that is not known.
  const IteratedRegistration registered =
      register_iteratively(data.source, data.target, data.scene, {}, {}, *session, progress);
  const Similarity after = similarity(data.source, pulled_back(data.target, registered.displacement));
  for (const Warning& warning :
       diagnose(data.source, data.target, similarity(data.source, data.target), after)) {
    if (warning.kind == no_likeness) {
      throw InputError(fmt::format("detect: {} {}", warning.message, warning.advice));
    }
  }
  const Detection found = detect_modulus(data.source, data.target, registered.displacement, data.region,
                                         data.scene, {.pairs = call[simulations]}, *session, progress);
  progress.clear();

  const auto as_much_by_chance =
      std::ranges::count_if(found.by_chance, [&](double most) { return most >= std::abs(found.largest); });
  json row = found;
  row.update(row_of(data.scene));
  row.update({{"placement", data.placement},
              {"backend", backend.name()},
              {"device", device.name},
              {"seconds", registered.seconds + found.seconds},
              {"registration_seconds", registered.seconds},
              {"region_sites", std::ranges::count_if(data.region.values, [](float v) { return v != 0.0F; })},
              {"simulations", found.by_chance.size()},
              {"as_much_by_chance", as_much_by_chance},
              {"largest_by_chance", std::ranges::max(found.by_chance)},
              {"contrast_undetermined", is_undetermined(found)},
              {"contrast_at_limit", is_at_limit(found)}});
  const auto name = [&](const char* file) { return beside(call[option::json], call[option::output], file); };
  write_scalar(call[option::output] / "modulus.nrrd", found.modulus, data.scene.spacing, data.placement);
  write_scalar(call[option::output] / "detection.nrrd", found.significance, data.scene.spacing,
               data.placement);
  row["modulus"] = name("modulus.nrrd");
  row["detection"] = name("detection.nrrd");
  write_png(picture_file(row, call, "source", "source"), data.source);
  write_signed_png(picture_file(row, call, "detection",
                                "significance over the source: red stiffer than the label says, blue softer, "
                                "full at 4 standard deviations"),
                   data.source.extent, found.significance.values, strong, data.source);

  fmt::print(
      "{}\n\n{} of {}\n\n", data.scene.title,
      row_text(
          "  {region_sites} sites of the region; error of the displacement, as white noise, {noise:.3g} px\n"
          "  unexplained by the labels' moduli {unexplained_before:.3g} px, by those found "
          "{unexplained:.3g} px\n"
          "  most significant {largest:.3g} standard deviations; by chance as much in "
          "{as_much_by_chance} of {simulations} simulations with nothing hidden, at most "
          "{largest_by_chance:.3g}\n"
          "  explained best by a disc at x = {x:.1f}, y = {y:.1f}, radius {radius:.1f} px,",
          row),
      contrast_text(found));
  fmt::print("  {}\n\n{}  {}: MPa; beside it detection.nrrd, standard deviations\n",
             verdict(as_much_by_chance > 0, found),
             row_text("  {seconds:.3g} s ({registration_seconds:.3g} of them the registration)\n", row),
             (call[option::output] / "modulus.nrrd").string());
  call.write(json::array({without_nulls(row)}));
  return success;
}

} // namespace

void add_register(CLI::App& program, Call& call) {
  add_command(
      program, call, "register", run_register,
      "Find the displacement between two pictures.\n"
      "Find the displacement between two pictures of one person, with the tissues' moduli (thesis Algorithms "
      "5 and 6);\nbetween two volumes with --iterate, without --roi.\n"
      "Writes DIR/displacement.nrrd and pictures before and after. Exit status 1 where the pictures have no "
      "likeness,\nare no more alike than before, or the displacement turns tissue over.",
      {pair_options(schedule_options(true)), iterate},
      {"source is required", "target is required", "--scene is required", "--slice needs --orientation"});
}

void add_detect(CLI::App& program, Call& call) {
  add_command(
      program, call, "detect", run_detect,
      "Find tissue stiffer or softer than it looks.\n"
      "Where is tissue stiffer or softer than its label says? (thesis Algorithm 7)\n"
      "Registers the two pictures, then finds the moduli in the region that explain the deformation.\n"
      "Writes DIR/modulus.nrrd and DIR/detection.nrrd.",
      {pair_options(Options{}), simulations},
      {"source is required", "target is required", "--scene is required", "--roi is required",
       "--slice needs --orientation"});
}

} // namespace hdmbench::commands
