#pragma once

#include "harness/judge/registration/rivals.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// A row of `rivals --knobs`: one thing is turned, all others are as usual. "told" is what the algorithm is
/// told of the tissue, which is not what the truth was made with.
struct KnobRow {
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string algorithm; ///< "Algorithm 6" registers a resection; "Algorithm 7" looks for inclusions
  std::string knob;
  double value = 0.0;
  std::int64_t cases = 0;
  double seconds = 0.0; ///< of a case, mean
  // Algorithm 6, means over the cases
  std::optional<double> tissue{};   ///< error, pixels
  std::optional<double> region{};   ///< error, pixels
  std::optional<double> outliers{}; ///< share of the sites that do not match, as the last iteration saw them
  std::optional<std::int64_t> not_converged{}; ///< cases
  std::optional<std::int64_t> folded{};        ///< cases with folds
  // Algorithm 7
  std::optional<double> area{};           ///< under the ROC
  std::optional<double> distance{};       ///< error of the position, median, pixels
  std::optional<std::int64_t> found{};    ///< of the cases with an inclusion, more than chance
  std::optional<std::int64_t> mistaken{}; ///< of as many without
};
void list_fields(Fields& fields, KnobRow& row);

/// Turns noise, size, contrast and what is told of Poisson's ratio, of moduli and of labels. Each row is that
/// of `cases` seeds.
[[nodiscard]] std::vector<KnobRow> turn_knobs(const Scene& scene, int cases, ElasticSession& session,
                                              Progress& progress);

} // namespace hdmbench
