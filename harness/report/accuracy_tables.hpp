#pragma once

#include "harness/report/accuracy_scenes.hpp"

#include <span>
#include <string>

/// The tables of one machine's accuracy, each a run of HTML; empty where no row has the data.
namespace hdmbench::report {

/// All scenes at a glance: RMSD to FEM, the thesis's and ours.
[[nodiscard]] std::string overview_table(std::span<const AccuracyScene> scenes);

/// Every method beside the thesis's figures for the same scene. A failed row says why.
[[nodiscard]] std::string methods_table(const AccuracyScene& scene);

/// The error split into model, optimisation and covariance, with a bar.
[[nodiscard]] std::string decomposition_table(const AccuracyScene& scene);

/// float32 against double, by backend.
[[nodiscard]] std::string arithmetic_table(const AccuracyScene& scene);

/// Variants beside the run as the scene says and beside the thesis.
[[nodiscard]] std::string variants_table(const AccuracyScene& scene);

/// RMSD to FEM near material interfaces and away from them.
[[nodiscard]] std::string interfaces_table(const AccuracyScene& scene);

/// "0", "0.0412", "1.540", "37.0", "3.1e-05": what a table shows of a distance in pixels.
[[nodiscard]] std::string distance_text(double pixels);

} // namespace hdmbench::report
