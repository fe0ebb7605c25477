#pragma once

#include "kernels/field.hpp"

#include <algorithm>
#include <vector>

namespace hdmbench {

/// Two doubles per site, planar: a displacement in pixels as the references compute it.
struct ReferenceField {
  ReferenceField() = default;
  explicit ReferenceField(Extent extent_, double fill = 0.0)
      : extent(extent_), x(extent_.sites(), fill), y(extent_.sites(), fill) {}
  /// The same values in double.
  explicit ReferenceField(const VectorField& field)
      : extent(field.extent), x(field.x.begin(), field.x.end()), y(field.y.begin(), field.y.end()) {}

  /// Rounded to float.
  [[nodiscard]] VectorField to_float() const {
    const auto round = [](double value) { return static_cast<float>(value); };
    VectorField field(extent);
    std::ranges::transform(x, field.x.begin(), round);
    std::ranges::transform(y, field.y.begin(), round);
    return field;
  }

  Extent extent;
  std::vector<double> x;
  std::vector<double> y;
};

} // namespace hdmbench
