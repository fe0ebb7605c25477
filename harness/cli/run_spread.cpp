#include "harness/cli/run_spread.hpp"

#include "backends/shared/stopwatch.hpp"
#include "harness/cli/run_files.hpp"
#include "harness/scene/points.hpp"

#include <array>
#include <cmath>
#include <utility>

namespace hdmbench::commands {

namespace {

const Option<int>
    uncertainty("--uncertainty",
                "How sure is the displacement? So many more solutions (20 are a good number), each "
                "with errors drawn: of points and targets by their deviations, and of what the "
                "tissue does by itself; --seed draws others",
                0, CLI::Range(0, 100'000));
const Option<double>
    uncertain_moduli("--uncertain-moduli",
                     "Of --uncertainty: draw the modulus of each label, too, log-normally; the "
                     "deviation of its logarithm, 0.2 for about 20 %",
                     0.0, CLI::Range(0.0, 5.0));
const Option<OutputFile>
    spread_file("--spread",
                "Of --uncertainty: write the standard deviation of the displacement of every "
                "site, mm: .nrrd, .mha or .nii.gz",
                Content::image);
const Option<OutputFile>
    mean_file("--mean", "Of --uncertainty: write the mean displacement, as --output has it", Content::image);

/// The length of the deviations of all components, mm.
ScalarField spread_in_mm(const Scene& scene, const Spread& how_sure) {
  ScalarField field = magnitude_of(how_sure.deviation);
  for (float& value : field.values) {
    value = static_cast<float>(value * scene.spacing);
  }
  return field;
}

} // namespace

Placement::Vector place_of(const Scene& scene, const std::array<double, 3>& at) {
  const auto way = [&](std::size_t axis) { return at[axis] * scene.full.sides[axis] * scene.spacing; };
  return scene.placement.moved(way(0), way(1), way(2)).origin;
}

Options spread_options() {
  return {uncertainty, uncertain_moduli, spread_file, mean_file};
}

SpreadOfRun asked_spread(Call& call) {
  if (call[uncertainty] == 0) {
    return {};
  }
  SpreadRequest request{.draws = call[uncertainty], .moduli = call[uncertain_moduli]};
  if (request.draws < 2) {
    throw InputError("--uncertainty 1: a deviation takes two solutions at least, 20 are a good number");
  }
  if (const auto seed = call.schedule.given.find("seed"); seed != call.schedule.given.end()) {
    const std::optional<int> number = number_of<int>(seed->second);
    if (!number || *number < 0) {
      throw InputError(fmt::format("--seed {}: a whole number that is not below 0", seed->second));
    }
    request.seed = static_cast<std::uint32_t>(*number);
    call.schedule.given.erase(seed);
  }
  return {.asked = request};
}

void require_spread(const Call& call, const Scene& scene, const SpreadOfRun& how_sure,
                    const std::vector<std::string>& names) {
  if (!how_sure.asked) {
    return;
  }
  require_spread(scene, *how_sure.asked);
  if (call.ranks != nullptr) {
    throw InputError("--uncertainty runs in one process, without mpirun");
  }
  for (const auto* file : {&call[spread_file], &call[mean_file]}) {
    if (file->empty()) {
      continue;
    }
    require_displacement_name(*file, scene.extent());
    if (file == &call[spread_file] && file->extension() == ".h5") {
      throw InputError(
          fmt::format("{}: a deviation is no transform; take .nrrd, .mha or .nii.gz", file->string()));
    }
    require_own_name(*file, file == &call[mean_file] ? "--mean" : "--spread", call[option::output], names);
  }
}

void draw_spread(const Scene& scene, const VectorField& solution, const Backend& backend,
                 const SessionOptions& session, Progress& progress, SpreadOfRun& how_sure, json& phases) {
  if (how_sure.asked) {
    const Clock clock;
    Solver solver(backend, session);
    how_sure.found = spread_of(scene, solution, *how_sure.asked, solver, progress);
    phases["uncertainty_seconds"] = clock.seconds();
  }
}

void report_spread(const Call& call, const Scene& scene, const SpreadOfRun& how_sure, json& row) {
  const auto& [request, found] = how_sure;
  if (!found) {
    return;
  }
  const ScalarField deviation = spread_in_mm(scene, *found);
  const LeastCertain& least = found->least_certain;
  const Placement::Vector at = place_of(scene, least.at);
  const double typical = found->typical * scene.spacing;
  const double moved = found->moved * scene.spacing;
  json& result = row["uncertainty"];
  result = {{"draws", request->draws},
            {"seed", request->seed},
            {"moduli", request->moduli},
            {"mean_mm", moved},
            {"deviation_mm", typical},
            {"largest_mm", least.deviation * scene.spacing},
            {"at_mm", at}};
  fmt::print(
      "  how sure is it, by {} draws: on average it moves {:.3g} mm, with a standard deviation of {:.3g} mm "
      "(RMS);\n"
      "  the least is known around {:.4g}, {:.4g}, {:.4g} mm (LPS), {:.3g} mm: measure here next\n",
      request->draws, moved, typical, at[0], at[1], at[2], least.deviation * scene.spacing);
  const auto write = [&](const char* key, const OutputFile& file, const auto& write_it) {
    if (!file.empty() && have_images()) {
      write_it(file);
      result[key] = beside(call[option::json], file.parent_path(), file.filename());
      fmt::print("  {}: the {} of the displacement in millimetres\n", file.string(),
                 key == std::string_view("mean") ? "mean" : "standard deviation");
    }
  };
  write("spread", call[spread_file],
        [&](const auto& file) { write_scalar(file, deviation, scene.spacing, scene.placement); });
  write("mean", call[mean_file], [&](const auto& file) {
    write_displacement(file, found->mean, scene.spacing, scene.placement, scene.oblong);
  });
}

} // namespace hdmbench::commands
