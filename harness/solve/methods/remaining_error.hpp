#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace hdmbench {

/// How far a field is from its end, from how far the steps of conjugate gradients moved it. The more a step
/// is of the one before, its share, the more is left; and the more the larger the contrast of the moduli,
/// whose slow parts of the error hide. The numbers fit scenes with other seeds than those of
/// test/promise_test, which prints how far off the estimates are.
class RemainingError {
public:
  /// `contrast`: contrast_of() the sheet's moduli.
  explicit RemainingError(double contrast) : contrast_(contrast) {}

  /// A step: RMS of the way, pixels.
  void add(double moved) { moved_.push_back(moved); }

  [[nodiscard]] bool is_known() const { return !moved_.empty(); }

  /// RMS of what is left, pixels: as likely too low as too high.
  [[nodiscard]] double estimate() const {
    const double of_moduli = std::min(contrast_, 1000.0); // no scene that was fitted had more
    const double left = moved_.size() < 2
                            ? 0.1 * std::pow(of_moduli, 0.26)
                            : 0.58 * std::pow(of_moduli, 0.12) * std::pow(std::max(share(), 0.02), 0.65);
    return left * moved_.back();
  }

  /// The same for a decision, pixels: hardly ever too low, whatever the moduli. Later steps are taken to go
  /// on as the last ones did, and partly in the same direction: between their sum and the root of the sum of
  /// their squares.
  [[nodiscard]] double cautious_estimate() const {
    if (moved_.size() < 2) {
      return 0.4 * moved_.back();
    }
    const double of_last = std::clamp(share(), 0.15, 0.85);
    return 0.7 * moved_.back() * std::sqrt(of_last / (1.0 - of_last));
  }

  /// Whether what is left is within `accuracy`, pixels, with a margin for an estimate that is wrong. It is
  /// wider after a first step, and at large contrasts, where steps can be small for a while.
  [[nodiscard]] bool is_within(double accuracy) const {
    if (!is_known()) {
      return false;
    }
    const double pauses = std::max(1.0, std::sqrt(contrast_ / 50.0));
    const double margin = moved_.size() == 1 ? 6.0 : 4.0;
    return pauses * std::max(3.0 * cautious_estimate(), margin * moved_.back()) <= accuracy;
  }

private:
  /// What a step is of the one before, over the last ones.
  [[nodiscard]] double share() const {
    const std::size_t ratios = std::min(most_ratios, moved_.size() - 1);
    const double before = moved_[moved_.size() - 1 - ratios];
    return before > 0.0 ? std::pow(moved_.back() / before, 1.0 / static_cast<double>(ratios)) : 0.0;
  }

  static constexpr std::size_t most_ratios = 5;
  double contrast_;
  std::vector<double> moved_;
};

/// The same of cycles by themselves. They shrink by a share that tends to one of their own, so what is left
/// is a geometric series. The first one tells less: the larger the contrast, the more is left.
class CyclesError {
public:
  /// `rounding`: RMS that moves a field for ever, pixels.
  CyclesError(double contrast, double rounding) : contrast_(contrast), rounding_(rounding) {}

  void add(double moved) {
    if (moved_ > 0.0 && moved > rounding_) {
      share_ = std::min(moved / moved_, largest_share);
    }
    moved_ = moved;
  }

  /// RMS of what is left, pixels.
  [[nodiscard]] double estimate() const {
    const double of_next =
        share_ > 0.0 ? 1.3 * share_ / (1.0 - share_) : 0.5 * std::pow(std::min(contrast_, 1e6), 0.18);
    return moved_ * of_next;
  }

private:
  static constexpr double largest_share = 0.99;
  double contrast_;
  double rounding_;
  double moved_ = 0.0;
  double share_ = 0.0; ///< of a cycle's way in that of the one before; 0: not known yet
};

} // namespace hdmbench
