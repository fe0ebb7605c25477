#pragma once

#include "harness/judge/judge.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

struct AccuracyOptions {
  SessionOptions session{};
  int repeats = 3;            ///< samples of seconds per row
  bool quick = false;         ///< no variants, no arithmetic, no convergence
  int arithmetic_stride = 10; ///< see measure_arithmetic
  bool registration = false;  ///< also the elastic registration of the pictures (thesis 5.11); needs ITK
};

struct SceneAccuracy {
  Truths truths;
  std::vector<Judged> rows; ///< with their fields
};

/// What the elastic registration, a rival, is called.
inline constexpr std::string_view registration_name = "b-spline";

/// Why the field that a registration found cannot be taken for one: it moves a site by more than the image is
/// long, or is farther from the truth than no displacement at all. Empty where neither holds.
[[nodiscard]] std::string why_astray(const ReferenceField& found, const ReferenceField& truth);

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
