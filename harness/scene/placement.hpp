#pragma once

#include <array>
#include <cstddef>

namespace hdmbench {

/// Where an image or a volume lies in the patient, in ITK's convention: millimetres along axes that point
/// to the left, to the back and upwards (LPS). An image that says nothing of it begins at 0 and lies along
/// the axes.
struct Placement {
  using Vector = std::array<double, 3>;

  /// Returns the vector, whose axes point to the right, to the front and upwards (RAS), in LPS, and back.
  [[nodiscard]] static Vector turned(const Vector& vector) { return {-vector[0], -vector[1], vector[2]}; }

  Vector origin{}; ///< centre of the first pixel
  /// Unit vectors along the rows, along the columns, and from one slice to the next: the columns of ITK's
  /// direction. The first two are perpendicular, of a volume all three.
  std::array<Vector, 3> axes{{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  double thickness = 0.0;       ///< distance between slices; 0: the side of a pixel, as it is in a volume
  Vector aspect{1.0, 1.0, 1.0}; ///< each side of a pixel over the shortest one, as Level::sides

  /// The physical vector of one that leads `x` millimetres along the rows, `y` along the columns and `z`
  /// through the slices. Without the axes' own rounding where they are those of the space; it has no -0.
  [[nodiscard]] Vector vector(double x, double y, double z = 0.0) const {
    Vector sum{};
    for (std::size_t i = 0; i < sum.size(); ++i) {
      sum[i] = axes[0][i] * x + axes[1][i] * y + axes[2][i] * z + 0.0;
    }
    return sum;
  }

  /// The placement of an image whose first pixel lies there, seen from this one's.
  [[nodiscard]] Placement moved(double x, double y, double z = 0.0) const {
    Placement result = *this;
    const Vector way = vector(x, y, z);
    for (std::size_t i = 0; i < way.size(); ++i) {
      result.origin[i] += way[i];
    }
    return result;
  }

  friend bool operator==(const Placement&, const Placement&) = default;
};

} // namespace hdmbench
