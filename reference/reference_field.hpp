#pragma once

#include "kernels/field.hpp"

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

  Extent extent;
  std::vector<double> x;
  std::vector<double> y;
};

} // namespace hdmbench
