#pragma once

#include "harness/judge/judge.hpp"

#include <filesystem>
#include <span>
#include <vector>

namespace hdmbench {

struct AccuracyOptions {
  SessionOptions session{};
  int repeats = 3;    ///< samples of seconds per row
  bool quick = false; ///< no variants
};

struct SceneAccuracy {
  Truths truths;
  std::vector<Judged> rows; ///< with their fields
};

/// Rivals, then every method of the scene's energy on every backend, in both designs of the thesis. The first
/// backend is the reference for bits; it also runs the sequential method. Throws InputError as find_truths
/// does; a backend that is not there becomes a row without result.
[[nodiscard]] SceneAccuracy measure_accuracy(const Scene& scene, std::span<const Backend* const> backends,
                                             const AccuracyOptions& options, Progress& progress);

/// Writes the length of field - finite elements without Poisson effect as a picture beside the results, one
/// pixel per site: black 0 ... light yellow the largest. Returns its part of the row: where it is and that
/// largest length. Throws InputError where the file cannot be written.
[[nodiscard]] nlohmann::json write_difference(const Scene& scene, const Truths& truths, const Judged& row,
                                              const std::filesystem::path& json_folder);

/// A sheet with a round inclusion, whose displacement is known in closed form
/// (reference/round_inclusion.hpp) and prescribed on the border, on meshes of pixels: a row {energy,
/// width, height, contrast: modulus of the inclusion over that around it, poisson, stretch: how much longer
/// the image gets, pixels, backend, device, method: that of `algebraic`} for each side, and four distances
/// {rmsd, largest of any site} in pixels: `discretisation`, of finite elements on the pixels (direct, double)
/// from the closed form; `algebraic`, of our field from these; `rounding`, of our field when no step changes
/// it any more (float32) from these; `total`, of our field from the closed form. From the second row on
/// `order`, that of discretisation.rmsd in the width since the first one. Sides rise and are 8 pixels at
/// least. Throws InputError, and what a session throws.
[[nodiscard]] nlohmann::json measure_continuum(double contrast, std::span<const int> sides,
                                               const Backend& backend, const SessionOptions& options,
                                               Progress& progress);

} // namespace hdmbench
