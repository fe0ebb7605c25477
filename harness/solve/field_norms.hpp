#pragma once

#include "kernels/data/field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hdmbench {

/// Of two fields of one extent: the root of the mean square of the distance, pixels.
[[nodiscard]] inline double rms_difference(const VectorField& a, const VectorField& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    const auto x = static_cast<double>(a.x[i]) - static_cast<double>(b.x[i]);
    const auto y = static_cast<double>(a.y[i]) - static_cast<double>(b.y[i]);
    squares += x * x + y * y;
  }
  return std::sqrt(squares / static_cast<double>(a.x.size()));
}

/// The largest |component|, pixels; infinite where one is not a number, 0 of an empty field.
[[nodiscard]] inline double largest_component(const VectorField& field) {
  float largest = 0.0F;
  for (const auto* const component : {&field.x, &field.y}) {
    for (const float value : *component) {
      largest =
          std::isnan(value) ? std::numeric_limits<float>::infinity() : std::max(largest, std::abs(value));
    }
  }
  return static_cast<double>(largest);
}

} // namespace hdmbench
