#pragma once

#include "kernels/data/field.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench::images {

/// Bilinear interpolation at a finite position in pixels, pixel centres at integers; beyond the outer centres
/// the nearest pixel of the border.
[[nodiscard]] inline float linear_at(const ScalarField& field, double x, double y) {
  const double inside_x = std::clamp(x, 0.0, field.extent.width - 1.0);
  const double inside_y = std::clamp(y, 0.0, field.extent.height - 1.0);
  const int left = static_cast<int>(inside_x);
  const int top = static_cast<int>(inside_y);
  const int right = std::min(left + 1, field.extent.width - 1);
  const int bottom = std::min(top + 1, field.extent.height - 1);
  const auto value = [&](int column, int row) {
    return double{field.values[field.extent.index(column, row)]};
  };
  const double upper = std::lerp(value(left, top), value(right, top), inside_x - left);
  const double lower = std::lerp(value(left, bottom), value(right, bottom), inside_x - left);
  return static_cast<float>(std::lerp(upper, lower, inside_y - top));
}

/// The pixel whose area a finite position lies in, or the nearest one of the border.
[[nodiscard]] inline float nearest_at(const ScalarField& field, double x, double y) {
  const double column = std::clamp(std::floor(x + 0.5), 0.0, field.extent.width - 1.0);
  const double row = std::clamp(std::floor(y + 0.5), 0.0, field.extent.height - 1.0);
  return field.values[field.extent.index(static_cast<int>(column), static_cast<int>(row))];
}

} // namespace hdmbench::images
