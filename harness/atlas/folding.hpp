#pragma once

#include "kernels/field.hpp"

#include <vector>

namespace hdmbench::atlas {

/// The smallest det(I + grad d) in every cell between four sites, (width - 1) x (height - 1) values in raster
/// order; not positive where x -> x + d(x) folds over. d is bilinear in a cell, and then the determinant is
/// linear along each axis, so that its minimum lies at a corner.
[[nodiscard]] std::vector<float> smallest_determinants(const VectorField& displacement);

} // namespace hdmbench::atlas
