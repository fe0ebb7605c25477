#include "harness/judge/accuracy/accuracy_row.hpp"

#include "harness/measure/median.hpp"
#include "harness/scene/images/images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace hdmbench {

namespace {

namespace fs = std::filesystem;

/// Four significant digits: what a figure can show.
double rounded(double value) {
  if (value == 0.0 || !std::isfinite(value)) {
    return value;
  }
  const double scale = std::pow(10.0, 3.0 - std::floor(std::log10(std::abs(value))));
  return std::round(value * scale) / scale;
}

template <typename Number>
std::vector<double> rounded(const std::vector<Number>& values) {
  std::vector<double> result;
  std::ranges::transform(values, std::back_inserter(result),
                         [](Number value) { return rounded(static_cast<double>(value)); });
  return result;
}

figures::Profiles rounded(const figures::Profiles& profiles) {
  return {rounded(profiles.horizontal), rounded(profiles.vertical), rounded(profiles.falling),
          rounded(profiles.rising)};
}

/// Positions to a hundredth of a pixel.
std::vector<figures::Polyline> to_hundredths(std::vector<figures::Polyline> lines) {
  for (figures::Polyline& line : lines) {
    std::ranges::transform(line, line.begin(),
                           [](double value) { return std::round(value * 100.0) / 100.0; });
  }
  return lines;
}

Arithmetic arithmetic_of(const ArithmeticError& error, std::optional<double> rmsd_to_double) {
  return {{error.iterations, error.steps_compared, error.steps_differing, error.beyond_bound,
           error.largest_gap_over_bound, error.rmsd()},
          rmsd_to_double};
}

void add_deviations(AccuracyRow& row, const Truths& truths, const Deviations& deviations) {
  row.to_fem = {deviations.to_fem, deviations.free_to_fem};
  row.to_fem_nu0 = {deviations.to_fem_no_poisson, deviations.free_to_fem_no_poisson};
  row.to_fixed_point = {deviations.to_fixed_point, deviations.free_to_fixed_point};
  if (deviations.interface_to_fem) {
    row.interface = {deviations.interface_to_fem, deviations.elsewhere_to_fem,
                     static_cast<std::int64_t>(truths.interface_sites),
                     static_cast<std::int64_t>(truths.free_sites - truths.interface_sites)};
  }
}

/// Writes field - finite elements without Poisson effect as three pictures.
Differences write_differences(const Scene& scene, const SceneAccuracy& accuracy, const JudgedField& judged,
                              const fs::path& folder, const fs::path& json_folder) {
  const ReferenceField error = difference(judged.field, accuracy.truths.elastic_no_poisson.displacement);
  const VectorField picture = error.to_float();
  double limit = 0.0;
  for (std::size_t i = 0; i < error.x.size(); ++i) {
    limit = std::max(limit, std::hypot(error.x[i], error.y[i]));
  }
  limit = std::max(limit, 1e-6);
  Differences result{.pictures = {}, .limit = limit, .against = "fem nu 0"};
  const auto file = [&](const char* what, std::string& name) {
    fs::path path = folder / fmt::format("{}-{}-difference-{}.png", scene.name, scene.extent().width, what);
    name = fs::proximate(path, json_folder).lexically_normal().string();
    return path;
  };
  write_magnitude_png(file("magnitude", result.pictures.magnitude), picture, limit);
  write_signed_png(file("x", result.pictures.x), picture.extent, picture.x, limit);
  write_signed_png(file("y", result.pictures.y), picture.extent, picture.y, limit);
  return result;
}

void add_figures(AccuracyRow& row, const JudgedField& judged) {
  row.convergence = judged.convergence;
  if (judged.profiles) {
    row.profiles = rounded(*judged.profiles);
  }
  for (const figures::LevelProfile& profile : judged.level_profiles) {
    row.level_profiles.push_back(
        {.level = profile.level,
         .width = profile.extent.width,
         .height = profile.extent.height,
         .horizontal = {rounded(profile.horizontal_x), rounded(profile.horizontal_y)},
         .vertical = {rounded(profile.vertical_x), rounded(profile.vertical_y)}});
  }
  if (judged.grid) {
    row.grid = {static_cast<double>(judged.grid->spacing), to_hundredths(judged.grid->lines)};
    row.interfaces = to_hundredths(judged.grid->interfaces);
  }
}

AccuracyRow row_of(const Scene& scene, const Truths& truths, const JudgedField& judged) {
  AccuracyRow row{.scene = scene.name,
                  .title = scene.title,
                  .width = scene.extent().width,
                  .height = scene.extent().height,
                  .poisson = scene.poisson,
                  .method = judged.method,
                  .variant = judged.variant,
                  .note = judged.note,
                  .energy = std::string(
                      judged.energy ? energy_names.at(static_cast<std::size_t>(*judged.energy)) : "none"),
                  .backend = judged.backend,
                  .device = judged.device.name,
                  .status = judged.status,
                  .valid = judged.valid,
                  .poisson_used = judged.poisson_used};
  if (judged.field.x.empty()) {
    return row;
  }
  row.seconds = judged.seconds;
  row.seconds_median = median(judged.seconds);
  row.mean_energy = judged.mean_energy;
  add_deviations(row, truths, judged.deviations);
  if (!judged.levels.empty()) {
    row.iterations = total_iterations(judged.levels);
    row.levels = judged.levels;
    row.fine_sweep_equivalents =
        total_site_updates(judged.levels) / static_cast<double>(scene.extent().sites());
  }
  row.decompositions = judged.decompositions;
  if (judged.arithmetic) {
    row.arithmetic = arithmetic_of(*judged.arithmetic, judged.rmsd_to_double);
  }
  add_figures(row, judged);
  return row;
}

} // namespace

std::vector<AccuracyRow> accuracy_rows(const Scene& scene, const SceneAccuracy& accuracy,
                                       const fs::path& pictures, const fs::path& json_folder) {
  std::vector<AccuracyRow> rows;
  for (const JudgedField& judged : accuracy.rows) {
    rows.push_back(row_of(scene, accuracy.truths, judged));
    if (judged.with_difference && !judged.field.x.empty() && !pictures.empty()) {
      rows.back().differences = write_differences(scene, accuracy, judged, pictures, json_folder);
    }
  }
  return rows;
}

} // namespace hdmbench
