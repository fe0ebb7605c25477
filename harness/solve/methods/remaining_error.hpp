#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace hdmbench {

/// How far a field is from its end, from how far the steps of conjugate gradients moved it. Later steps go
/// on as the last ones did, and partly in the same direction: between their sum and the root of the sum of
/// their squares, so that what is left is about 0.7 of the last step times sqrt(share / (1 - share)), where a
/// step is `share` of the one before. The numbers fit scenes with other seeds than those of
/// test/promise_test, which prints how far off the estimates are: a slow part of the error can hide for some
/// steps.
class RemainingError {
public:
  /// A step: RMS of the way, pixels.
  void add(double moved) { moved_.push_back(moved); }

  [[nodiscard]] bool is_known() const { return !moved_.empty(); }

  /// RMS of what is left, pixels; after a first step little more than a guess.
  [[nodiscard]] double estimate() const {
    if (moved_.size() < 2) {
      return first_share * moved_.back();
    }
    const std::size_t ratios = std::min(most_ratios, moved_.size() - 1);
    const double before = moved_[moved_.size() - 1 - ratios];
    const double mean =
        before > 0.0 ? std::pow(moved_.back() / before, 1.0 / static_cast<double>(ratios)) : 0.0;
    const double share = std::clamp(mean, 0.15, 0.85);
    return 0.7 * moved_.back() * std::sqrt(share / (1.0 - share));
  }

  /// Whether what is left is within `accuracy`, pixels, with a margin for an estimate that is wrong, a wider
  /// one after a first step.
  [[nodiscard]] bool is_within(double accuracy) const {
    const double margin = moved_.size() == 1 ? 6.0 : 4.0;
    return is_known() && 3.0 * estimate() <= accuracy && margin * moved_.back() <= accuracy;
  }

private:
  static constexpr double first_share = 0.4;
  static constexpr std::size_t most_ratios = 5;
  std::vector<double> moved_;
};

} // namespace hdmbench
