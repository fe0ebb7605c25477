#pragma once

#include "harness/judge/judge.hpp"

#include <filesystem>
#include <span>
#include <vector>

namespace hdmbench {

struct AccuracyOptions {
  SessionOptions session{};
  int repeats = 3;            ///< samples of seconds per row
  bool quick = false;         ///< no variants, no arithmetic, no convergence
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

} // namespace hdmbench
