#pragma once

#include "harness/measure/comparison/rank_test.hpp"

#include <array>
#include <span>
#include <string>
#include <string_view>

namespace hdmbench::comparison {

enum class Change {
  none_seen, ///< p >= significant_p, and the interval has no room for a change beyond the tolerance
  faster,    ///< p < significant_p
  slower,    ///< p < significant_p
  too_noisy, ///< p >= significant_p, but the interval has room for a change beyond the tolerance
  too_few,   ///< so few samples that p < significant_p cannot come out
};

/// What tables and results call them, in the order of the enumerators.
inline constexpr std::array<std::string_view, 5> change_names{"no difference seen", "faster", "slower",
                                                              "too noisy to say", "too few samples"};

[[nodiscard]] constexpr const auto& names_of(Change) {
  return change_names;
}

inline constexpr double significant_p = 0.01;

struct Comparison {
  Change change = Change::too_few;
  double first_median = 0.0; ///< seconds
  double second_median = 0.0;
  double ratio_of_medians = 1.0; ///< second over first
  Ratio ratio;                   ///< second over first
  double p = 1.0;
  /// Standard deviations relative to the value, from the median absolute deviation of the logarithms, which
  /// single outliers do not move.
  double first_spread = 0.0;
  double second_spread = 0.0;
  /// The spread of both sides with which so many samples see a change of the tolerance's size (p <
  /// significant_p) in nine of ten comparisons. With more, it is easily overlooked.
  double largest_good_spread = 0.0;
  std::size_t samples_needed = 0; ///< a side, to see the same with the spread there is
  bool slower_than_tolerated = false;

  [[nodiscard]] bool noisy() const {
    return first_spread > largest_good_spread || second_spread > largest_good_spread;
  }
};

/// `tolerance`: 0.05 tolerates a ratio up to 1.05 (and, to be called no difference, down to 1 / 1.05).
/// Seconds > 0; a side may be empty.
[[nodiscard]] Comparison compare_samples(std::span<const double> first, std::span<const double> second,
                                         double tolerance);

/// "noise: spread 7.1 % old, 6.9 % new; to see 5 % takes at most 2.8 %, or 66 samples a side"; empty where
/// nothing needs saying.
[[nodiscard]] std::string noise_text(const Comparison& comparison, double tolerance);

/// The fewest samples >= `at_least` of the second side with which p < significant_p can come out.
[[nodiscard]] std::size_t samples_that_can_tell(std::size_t first, std::size_t at_least);

} // namespace hdmbench::comparison
