#pragma once

#include "test/report_samples.hpp"

/// Rows of `hdmbench accuracy` with invented figures on an image of 4 x 3 sites.
namespace hdmbench::report_samples {

inline json accuracy_row(const std::string& method, const std::string& backend = "",
                         const std::string& scene = "square") {
  json row =
      json::parse(R"({"title": "A square", "width": 4, "height": 3, "poisson": 0.3, "variant": "", "note": "",
    "device": "", "status": "ok", "valid": true, "seconds": [0.9, 1.0, 1.1], "seconds_median": 1.0,
    "mean_energy": 0.0035, "rmsd_to_fem": 0.75, "rmsd_free_to_fem": 0.875, "rmsd_to_fem_nu0": 0.5,
    "rmsd_free_to_fem_nu0": 0.625, "rmsd_to_fixed_point": 0.25, "rmsd_free_to_fixed_point": null,
    "rmsd_interface_to_fem": 1.5, "rmsd_elsewhere_to_fem": 0.75, "interface_sites": 5, "elsewhere_sites": 6})");
  row.update({{"method", method}, {"backend", backend}, {"scene", scene}});
  if (method == "icm" || method == "sequential") {
    row.update(json::parse(R"({"iterations": 30, "fine_sweep_equivalents": 12.5, "levels": [
        {"level": 2, "width": 1, "height": 1, "iterations": 7}, {"level": 1, "width": 2, "height": 2, "iterations": 11},
        {"level": 0, "width": 4, "height": 3, "iterations": 12}],
      "decompositions": [
        {"poisson": 0.3, "total": 1.5, "model": 1.0, "optimisation": 0.5, "covariance": 0.5, "remainder": 0.0},
        {"poisson": 0.0, "total": 1.0, "model": 1.0, "optimisation": 0.5, "covariance": -0.125, "remainder": 1e-16}]})"));
  }
  if (method.starts_with("fem")) {
    row["poisson_used"] = 0.3;
  }
  return row;
}

inline json fem_row(double poisson_used) {
  json row = accuracy_row("fem");
  row["poisson_used"] = poisson_used;
  return row;
}

inline json with_arithmetic(json row) {
  row["arithmetic"] = json::parse(R"({"double_rmsd": 3e-5, "resynchronised": {"iterations": 30,
    "steps_compared": 4321, "steps_differing": 3, "largest_gap_over_bound": 0.25, "rmsd": 1.5e-5, "beyond_bound": 0}})");
  return row;
}

inline json with_profiles(json row) {
  row["profiles"] = json::parse(R"({"horizontal": [0.0, 1.0, 2.0, 3.0], "vertical": [0.0, -1.0, -2.0],
    "falling": [0.0, 0.5, 1.0, 1.5], "rising": [1.5, 1.0, 0.5, 0.0]})");
  return row;
}

inline json with_grid(json row) {
  row.update(json::parse(R"({"grid": {"spacing": 2, "lines": [[0, 0, 1.04, 0, 3.26, -1], [0, 2, 3, 2]]},
    "interfaces": [[1, 1, 2, 1, 2, 2]]})"));
  return row;
}

/// All figures; the pictures are f.png, which `figure_picture` has the bytes of.
inline json with_all_figures(json row) {
  row = with_grid(with_profiles(with_arithmetic(std::move(row))));
  row.update(json::parse(R"({
    "convergence": {"iterations_per_level": [1, 10, 50], "rmsd_to_fem": [3.0, 1.0, 0.75],
      "rmsd_to_fixed_point": [2.5, 0.5, 0.25], "mean_energy": [0.5, 0.01, 0.0035]},
    "level_profiles": [
      {"level": 1, "width": 1, "height": 1, "horizontal": {"x": [1], "y": [2]}, "vertical": {"x": [1], "y": [2]}},
      {"level": 0, "width": 4, "height": 3, "horizontal": {"x": [0, 1, 2, 3], "y": [1, 1, 1, 1]},
       "vertical": {"x": [0, 1, 2], "y": [1, 1, 1]}}],
    "differences": {"pictures": {"magnitude": "f.png", "x": "f.png", "y": "f.png"}, "limit": 2.5,
      "against": "fem nu 0"}})"));
  return row;
}

/// The head of a PNG of 4 x 3 pixels; the report reads no further.
inline std::string figure_picture() {
  return {"\x89PNG\r\n\x1A\n\0\0\0\x0DIHDR\0\0\0\x04\0\0\0\x03", 24};
}

/// What a good run writes for one scene, without figures: they take a plot each.
inline json accuracy_rows() {
  return rows(with_arithmetic(accuracy_row("icm", "scalar")), with_arithmetic(accuracy_row("icm", "openmp")),
              accuracy_row("sequential", "scalar"), accuracy_row("fixed-point"), fem_row(0.3), fem_row(0.0),
              accuracy_row("fem-coarse"), accuracy_row("interpolation"), accuracy_row("b-spline"));
}

/// The same with them.
inline json accuracy_rows_with_figures() {
  json results = accuracy_rows();
  results[0] = with_all_figures(results[0]);
  for (const std::size_t i : {2, 3, 4, 5, 7}) {
    results[i] = with_profiles(results[i]);
  }
  for (const std::size_t i : {4, 8}) {
    results[i] = with_grid(results[i]);
  }
  return results;
}

} // namespace hdmbench::report_samples
