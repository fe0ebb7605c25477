#pragma once

#include "harness/measure/result_file.hpp"

#include <array>
#include <span>
#include <string_view>

/// Timings of before and after a change. What goes beyond one test of ranks is for Google Benchmark's
/// compare.py, which reads bench --benchmark-json.
namespace hdmbench {

enum class Change {
  faster,       ///< the new samples are smaller
  not_slower,   ///< the new samples are not slower by more than the tolerance
  slower,       ///< the new samples are larger, and their median is by more than the tolerance
  inconclusive, ///< the samples are too few or too noisy to show any of these
};
inline constexpr std::array<std::string_view, 4> change_names{"faster", "not slower", "slower",
                                                              "inconclusive"};

/// A change counts as shown below this chance.
inline constexpr double significant_p = 0.01;

/// The chance with which the second samples would be so much larger than the first ones if both were of one
/// distribution: the one-sided test of Mann and Whitney (1947) with the normal approximation, corrected for
/// ties and continuity. 1 where a side is empty.
[[nodiscard]] double chance_of_larger(std::span<const double> first, std::span<const double> second);

struct ChangeOfTimes {
  double old_median = 0.0; ///< seconds
  double new_median = 0.0;
  double p = 1.0; ///< chance_of_larger() of what `change` says
  Change change = Change::inconclusive;
};

/// Of seconds > 0. `tolerance`: 0.05 bears a time that is 1.05 times as long.
[[nodiscard]] ChangeOfTimes compare_times(std::span<const double> before, std::span<const double> after,
                                          double tolerance);

/// A row for every row of `before` that has timings of a field that nobody found wrong, with the row of
/// `after` that has the same scene, size, backend, method and, where both tell, threads: what was computed,
/// the medians "old_s" and "new_s", "ratio", "p", "verdict" and "passes", which is false unless it was shown
/// to be no slower, by the same work on the same device. Throws InputError that names file and row where
/// something is missing, mistyped or contradictory.
[[nodiscard]] nlohmann::json compare_results(const ResultFile& before, const ResultFile& after,
                                             double tolerance);

} // namespace hdmbench
