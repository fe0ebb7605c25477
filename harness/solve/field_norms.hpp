#pragma once

#include "kernels/data/field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hdmbench {

/// Of two fields of one extent: the root of the mean square of the distance, pixels.
[[nodiscard]] inline double rms_difference(const VectorField& a, const VectorField& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a[0].size(); ++i) {
    const auto x = static_cast<double>(a[0][i]) - static_cast<double>(b[0][i]);
    const auto y = static_cast<double>(a[1][i]) - static_cast<double>(b[1][i]);
    squares += x * x + y * y;
  }
  return std::sqrt(squares / static_cast<double>(a[0].size()));
}

/// The largest |component|, pixels; infinite where one is not a number, 0 of an empty field.
[[nodiscard]] inline double largest_component(const VectorField& field) {
  float largest = 0.0F;
  for (const auto* const component : {&field[0], &field[1]}) {
    for (const float value : *component) {
      largest =
          std::isnan(value) ? std::numeric_limits<float>::infinity() : std::max(largest, std::abs(value));
    }
  }
  return static_cast<double>(largest);
}

} // namespace hdmbench
