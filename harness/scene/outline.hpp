#pragma once

#include "kernels/data/field.hpp"

#include <vector>

namespace hdmbench {

/// The surroundings of a region's outline.
struct Outline {
  ScalarField distance; ///< pixels to the outline, negative inside the region
  VectorField normal;   ///< unit vectors away from the region, (0, 0) where there is no direction
};

/// `inside` has one flag per site. Exact Euclidean distances (P. Felzenszwalb and D. Huttenlocher, "Distance
/// transforms of sampled functions", 2012), smoothed over a few pixels before the normals are taken, so that
/// these do not follow the pixel staircase. The region must be neither empty nor everything.
[[nodiscard]] Outline find_outline(const std::vector<bool>& inside, Extent extent);

/// `inside` with every gap filled that a disc of `radius` pixels does not fit into from outside: a
/// morphological closing, for a brain the envelope over its furrows. Beyond the image there is nothing.
[[nodiscard]] std::vector<bool> close_gaps(const std::vector<bool>& inside, Extent extent, double radius);

} // namespace hdmbench
