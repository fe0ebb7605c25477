#pragma once

#include "kernels/data/field.hpp"

namespace hdmbench {

/// How a displacement changes, pixels per pixel: xy is that of its x component along y.
struct Gradient {
  double xx = 0.0;
  double xy = 0.0;
  double yx = 0.0;
  double yy = 0.0;

  /// det(I + grad d): the area that a pixel takes, relative to before; below 0 where it is turned over.
  [[nodiscard]] double area_ratio() const { return (1.0 + xx) * (1.0 + yy) - xy * yx; }
};

/// At (r, s), each -1 ... 1, of the cell whose first corner is site (x, y), between whose four sites the
/// displacement is bilinear. Not rounded at a corner.
[[nodiscard]] inline Gradient gradient_in_cell(const VectorField& displacement, int x, int y, double r,
                                               double s) {
  const Extent extent = displacement.extent;
  const auto along = [](const std::vector<float>& of, std::size_t first, std::size_t step, std::size_t across,
                        double place) {
    const auto difference = [&](std::size_t from) {
      return static_cast<double>(of[from + step]) - static_cast<double>(of[from]);
    };
    return 0.5 * ((1.0 - place) * difference(first) + (1.0 + place) * difference(first + across));
  };
  const std::size_t first = extent.index(x, y);
  const auto row = static_cast<std::size_t>(extent.width);
  return {.xx = along(displacement.x, first, 1, row, s),
          .xy = along(displacement.x, first, row, 1, r),
          .yx = along(displacement.y, first, 1, row, s),
          .yy = along(displacement.y, first, row, 1, r)};
}

} // namespace hdmbench
