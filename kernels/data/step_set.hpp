#pragma once

#include "kernels/data/default_steps.hpp"
#include "kernels/data/input_error.hpp"

#include <array>
#include <cmath>
#include <span>
#include <string>
#include <string_view>

namespace hdmbench {

/// The candidates Gamma of one ICM step in pixels, in order: among candidates of equal energy the first wins.
/// The same set serves x and y.
class StepSet {
public:
  /// Every kernel declares its array with this size.
  static constexpr int maximum_count = 16;

  /// {0, -1, -0.1, +1, +0.1}: 0 stands first, so a site stays where moving does not pay.
  StepSet() : StepSet(default_steps) {}

  /// 1 to 16 finite values. Throws InputError.
  explicit StepSet(std::span<const float> values) : count_(static_cast<int>(values.size())) {
    if (values.empty() || values.size() > maximum_count) {
      throw InputError("the step set has " + std::to_string(values.size()) +
                       " candidates; give 1 to 16, for example 0,-1,1");
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i])) {
        throw InputError("the step set has the candidate " + std::to_string(values[i]) +
                         ", all must be finite");
      }
      values_[i] = values[i];
    }
  }

  /// "default"; "thesis" {-1, -0.1, +1, +0.1} (the printed set with its misprint mended: without 0 the field
  /// never rests); "fine" (default and -0.01, +0.01); or numbers with commas between, "0,-1,1". Throws
  /// InputError.
  static StepSet parse(std::string_view text);

  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] std::span<const float> values() const {
    return {values_.data(), static_cast<std::size_t>(count_)};
  }
  /// All 16, the unused ones 0: what a kernel is given.
  [[nodiscard]] const std::array<float, maximum_count>& padded() const { return values_; }
  /// "0, -1, -0.1, 1, 0.1".
  [[nodiscard]] std::string text() const;

private:
  std::array<float, maximum_count> values_{};
  int count_ = 0;
};

} // namespace hdmbench
