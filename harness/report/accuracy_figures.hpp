#pragma once

#include "harness/report/accuracy_scenes.hpp"
#include "harness/report/html.hpp"

#include <string>

/// The figures of one scene: HTML with a caption, empty where no row has the data. The plots need gnuplot.
namespace hdmbench::report {

/// RMSD to FEM over seconds, both logarithmic: a point per backend, method and thesis row.
[[nodiscard]] std::string tradeoff_figure(const AccuracyScene& scene, Anchors& anchors);

/// RMSD and mean energy over the iterations per level, beside the iterations that the in-place run needed on
/// each level.
[[nodiscard]] std::string convergence_figure(const AccuracyScene& scene, Anchors& anchors);

/// Displacement along the middle row, the middle column and both diagonals by every method, each with its
/// difference to FEM beneath. Throws InputError where two rows have diagonals of different lengths.
[[nodiscard]] std::string profile_figure(const AccuracyScene& scene, Anchors& anchors);

/// Both components along the middle row and the middle column of every level.
[[nodiscard]] std::string level_figure(const AccuracyScene& scene, Anchors& anchors);

/// The difference to FEM as pictures. Throws InputError where a picture is missing, not PNG, or not of the
/// size of the image.
[[nodiscard]] std::string difference_figure(const AccuracyScene& scene);

/// Deformed grids of ICM, FEM and B-spline registration, at one scale.
[[nodiscard]] std::string grid_figure(const AccuracyScene& scene);

} // namespace hdmbench::report
