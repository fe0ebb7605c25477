#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

/// Timings of two programs that were run in turn: whatever else the machine did, it did to both of a pair.
namespace hdmbench {

enum class Change {
  faster,       ///< the new program is
  not_slower,   ///< it is not slower by more than the tolerance
  slower,       ///< it is, by more than the tolerance
  inconclusive, ///< the pairs are too few, or differ too much, to show any of these
};
inline constexpr std::array<std::string_view, 4> change_names{"faster", "not slower", "slower",
                                                              "inconclusive"};

/// The chance of any verdict in a comparison, of however many cases, where there is nothing to it.
inline constexpr double chance_of_a_false_verdict = 0.01;

/// The chance that of so many fair coins at least `heads` show heads.
[[nodiscard]] double chance_of_heads(std::size_t coins, std::size_t heads);

/// The fewest pairs that can show anything of one of so many cases.
[[nodiscard]] std::size_t fewest_pairs(std::size_t cases);

/// What the ratios new / old of the pairs of one of `cases` show, by a sign test: no distribution is assumed,
/// only that a pair of equal programs is as likely to come out one way as the other. `tolerance`: 0.05 bears
/// a time that is 1.05 times as long.
[[nodiscard]] Change judge_pairs(std::span<const double> ratios, double tolerance, std::size_t cases);

} // namespace hdmbench
