#pragma once

#include <cstddef>
#include <span>

/// What can be said of two sets of samples without knowing how they are distributed.
namespace hdmbench::comparison {

struct RankTest {
  double u = 0.0; ///< pairs in which the second sample is the larger, ties half: 0 ... first * second
  double p = 1.0; ///< two-sided
};

/// Mann and Whitney (1947). Up to `most_exact` values in all, p is exact: of all ways to deal the values to
/// the two sides, twice the share with a U at least as far out at that end, ties as they are. Beyond, the
/// normal approximation with the corrections for ties and continuity. p = 1 where a side is empty.
[[nodiscard]] RankTest rank_test(std::span<const double> first, std::span<const double> second);

inline constexpr std::size_t most_exact = 60;

/// The smallest p that so many samples can give, 2 / binomial(first + second, first): that of two sides that
/// do not overlap at all. 1 where a side is empty.
[[nodiscard]] double smallest_p(std::size_t first, std::size_t second);

/// How much larger the second sides's samples are.
struct Ratio {
  double estimate = 1.0; ///< median of second / first over all pairs (Hodges-Lehmann, of the logarithms)
  double low = 1.0;
  double high = 1.0;
  double coverage = 0.0; ///< of [low, high]: at least what was asked for where so few samples can give it
};

/// Of samples > 0, at least one a side. The interval inverts rank_test, so that it needs no distribution
/// either.
[[nodiscard]] Ratio ratio_of(std::span<const double> first, std::span<const double> second,
                             double coverage = 0.95);

} // namespace hdmbench::comparison
