#include "harness/accuracy/accuracy_json.hpp"

#include "harness/images.hpp"
#include "harness/median.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace hdmbench {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Four significant digits: what a figure can show.
double rounded(double value) {
  if (value == 0.0 || !std::isfinite(value)) {
    return value;
  }
  const double scale = std::pow(10.0, 3.0 - std::floor(std::log10(std::abs(value))));
  return std::round(value * scale) / scale;
}

template <typename Number>
json rounded_array(const std::vector<Number>& values) {
  json array = json::array();
  for (const Number value : values) {
    array.push_back(rounded(static_cast<double>(value)));
  }
  return array;
}

/// Positions to a hundredth of a pixel.
json lines_json(const std::vector<figures::Polyline>& lines) {
  json array = json::array();
  for (const figures::Polyline& line : lines) {
    json points = json::array();
    for (const double value : line) {
      points.push_back(std::round(value * 100.0) / 100.0);
    }
    array.push_back(std::move(points));
  }
  return array;
}

json to_json(const figures::Profiles& profiles) {
  return {{"horizontal", rounded_array(profiles.horizontal)},
          {"vertical", rounded_array(profiles.vertical)},
          {"falling", rounded_array(profiles.falling)},
          {"rising", rounded_array(profiles.rising)}};
}

json to_json(const figures::LevelProfile& profile) {
  return {{"level", profile.level},
          {"width", profile.extent.width},
          {"height", profile.extent.height},
          {"horizontal",
           {{"x", rounded_array(profile.horizontal_x)}, {"y", rounded_array(profile.horizontal_y)}}},
          {"vertical", {{"x", rounded_array(profile.vertical_x)}, {"y", rounded_array(profile.vertical_y)}}}};
}

json to_json(const Convergence& convergence) {
  return {{"iterations_per_level", convergence.iterations_per_level},
          {"rmsd_to_fem", convergence.rmsd_to_fem},
          {"rmsd_to_fixed_point", convergence.rmsd_to_fixed_point},
          {"mean_energy", convergence.mean_energy}};
}

json to_json(const AccuracyRow::Split& split) {
  return {{"poisson", split.poisson},
          {"total", split.parts.total},
          {"model", split.parts.model},
          {"optimisation", split.parts.optimisation},
          {"covariance", split.parts.covariance},
          {"remainder", split.parts.remainder()}};
}

json to_json(const ArithmeticError& error, std::optional<double> rmsd_to_double) {
  json result{{"resynchronised",
               {{"iterations", error.iterations},
                {"steps_compared", error.steps_compared},
                {"steps_differing", error.steps_differing},
                {"beyond_bound", error.beyond_bound},
                {"largest_gap_over_bound", error.largest_gap_over_bound},
                {"rmsd", error.rmsd()}}}};
  if (rmsd_to_double) {
    result["double_rmsd"] = *rmsd_to_double;
  }
  return result;
}

void add_deviations(json& row, const Truths& truths, const Deviations& deviations) {
  row["rmsd_to_fem"] = deviations.to_fem;
  row["rmsd_free_to_fem"] = deviations.free_to_fem;
  row["rmsd_to_fem_nu0"] = deviations.to_fem_no_poisson;
  row["rmsd_free_to_fem_nu0"] = deviations.free_to_fem_no_poisson;
  row["rmsd_to_fixed_point"] = deviations.to_fixed_point;
  row["rmsd_free_to_fixed_point"] = deviations.free_to_fixed_point;
  if (deviations.interface_to_fem) {
    row["rmsd_interface_to_fem"] = *deviations.interface_to_fem;
    row["rmsd_elsewhere_to_fem"] = *deviations.elsewhere_to_fem;
    row["interface_sites"] = truths.interface_sites;
    row["elsewhere_sites"] = truths.free_sites - truths.interface_sites;
  }
}

/// Writes field - finite elements without Poisson effect as three pictures.
json write_differences(const Scene& scene, const SceneAccuracy& accuracy, const AccuracyRow& row,
                       const fs::path& folder, const fs::path& json_folder) {
  const ReferenceField error = difference(row.field, accuracy.truths.elastic_no_poisson.displacement);
  const VectorField picture = error.to_float();
  double limit = 0.0;
  for (std::size_t i = 0; i < error.x.size(); ++i) {
    limit = std::max(limit, std::hypot(error.x[i], error.y[i]));
  }
  limit = std::max(limit, 1e-6);
  json files;
  const auto name = [&](const char* what) {
    fs::path file = folder / fmt::format("{}-{}-difference-{}.png", scene.name, scene.extent().width, what);
    files[what] = fs::proximate(file, json_folder).lexically_normal().string();
    return file;
  };
  write_magnitude_png(name("magnitude"), picture, limit);
  write_signed_png(name("x"), picture.extent, picture.x, limit);
  write_signed_png(name("y"), picture.extent, picture.y, limit);
  return {{"pictures", files}, {"limit", limit}, {"against", "fem nu 0"}};
}

json levels_json(const std::vector<LevelResult>& levels) {
  json array = json::array();
  for (const LevelResult& level : levels) {
    array.push_back({{"level", level.level},
                     {"width", level.extent.width},
                     {"height", level.extent.height},
                     {"iterations", level.iterations},
                     {"changed", level.changed}});
  }
  return array;
}

void add_figures(json& result, const AccuracyRow& row) {
  if (row.convergence) {
    result["convergence"] = to_json(*row.convergence);
  }
  if (row.profiles) {
    result["profiles"] = to_json(*row.profiles);
  }
  for (const figures::LevelProfile& profile : row.level_profiles) {
    result["level_profiles"].push_back(to_json(profile));
  }
  if (row.grid) {
    result["grid"] = {{"spacing", row.grid->spacing}, {"lines", lines_json(row.grid->lines)}};
    result["interfaces"] = lines_json(row.grid->interfaces);
  }
}

json row_json(const Scene& scene, const Truths& truths, const AccuracyRow& row) {
  json result{{"scene", scene.name},           {"title", scene.title},
              {"width", scene.extent().width}, {"height", scene.extent().height},
              {"poisson", scene.poisson},      {"method", row.method},
              {"variant", row.variant},        {"note", row.note},
              {"backend", row.backend},        {"device", row.device.name},
              {"status", row.status},          {"valid", row.valid}};
  if (row.poisson_used) {
    result["poisson_used"] = *row.poisson_used;
  }
  if (row.field.x.empty()) {
    return result;
  }
  result["seconds"] = row.seconds;
  result["seconds_median"] = median(row.seconds);
  result["mean_energy"] = row.mean_energy;
  add_deviations(result, truths, row.deviations);
  if (!row.levels.empty()) {
    result["iterations"] = total_iterations(row.levels);
    result["levels"] = levels_json(row.levels);
    result["fine_sweep_equivalents"] =
        total_site_updates(row.levels) / static_cast<double>(scene.extent().sites());
  }
  for (const AccuracyRow::Split& split : row.decompositions) {
    result["decompositions"].push_back(to_json(split));
  }
  if (row.arithmetic) {
    result["arithmetic"] = to_json(*row.arithmetic, row.rmsd_to_double);
  }
  add_figures(result, row);
  return result;
}

} // namespace

nlohmann::json to_json(const Scene& scene, const SceneAccuracy& accuracy, const fs::path& pictures,
                       const fs::path& json_folder) {
  json rows = json::array();
  for (const AccuracyRow& row : accuracy.rows) {
    rows.push_back(row_json(scene, accuracy.truths, row));
    if (row.with_difference && !row.field.x.empty() && !pictures.empty()) {
      rows.back()["differences"] = write_differences(scene, accuracy, row, pictures, json_folder);
    }
  }
  return rows;
}

} // namespace hdmbench
