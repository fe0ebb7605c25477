#pragma once

#include "harness/judge/registration/rivals.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// A row of `rivals --knobs`: one thing is turned, all others are as usual. "told" is what the algorithm is
/// told of the tissue, which is not what the truth was made with.
struct KnobRow : RegisteredScene {
  /// algorithm_5 and algorithm_6 register a resection, algorithm_7 looks for inclusions.
  std::string algorithm;
  std::string knob;
  double value = 0.0;
  std::int64_t cases = 0;
  double seconds = 0.0; ///< of a case, mean
  // Algorithms 5 and 6, means over the cases
  std::optional<double> tissue{};       ///< error, pixels
  std::optional<double> region{};       ///< error, pixels
  std::optional<double> conventional{}; ///< of 5: error in the region of the registration before it, pixels
  std::optional<double> believed{};     ///< of 5: mean confidence in that registration over tissue
  std::optional<double> outliers{}; ///< share of the sites that do not match, as the last iteration saw them
  std::optional<std::int64_t> not_converged{}; ///< cases
  std::optional<std::int64_t> folded{};        ///< cases with folds
  // Algorithm 7
  std::optional<double> area{};           ///< under the ROC
  std::optional<double> distance{};       ///< error of the position, median, pixels
  std::optional<std::int64_t> found{};    ///< of the cases with an inclusion, more than chance
  std::optional<std::int64_t> mistaken{}; ///< of as many without
  std::optional<std::int64_t> warned{}; ///< of `found`: the picture shows another tissue than the label says
  std::optional<std::int64_t> mistaken_warned{}; ///< of `mistaken`
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(KnobRow, scene, width, height, algorithm, knob, value, cases, seconds,
                                   tissue, region, conventional, believed, outliers, not_converged, folded,
                                   area, distance, found, mistaken, warned, mistaken_warned)

/// Turns noise, size, contrast and what is told of Poisson's ratio, of moduli and of labels. Each row is that
/// of `cases` seeds. Without `slow` Algorithm 5 is left out.
[[nodiscard]] std::vector<KnobRow> turn_knobs(const Scene& scene, int cases, bool slow,
                                              const Backend& backend, const SessionOptions& session,
                                              Progress& progress);

} // namespace hdmbench
