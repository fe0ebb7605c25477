#pragma once

#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <vector>

namespace hdmbench {

/// Of an image that samples `full` at about every stride-th pixel of both axes, so that its cells stay
/// squares; first and last sites coincide. stride >= 1.
[[nodiscard]] Extent sampled_extent(Extent full, int stride);

/// A coarse displacement on the full image.
struct Interpolated {
  VectorField field;        ///< pixels; components with a confidence above 0 are on their targets
  double largest_gap = 0.0; ///< pixels, of such a target to what was interpolated there
  bool has_springs = false; ///< such a component has a confidence below 1
};

[[nodiscard]] Interpolated interpolate_to_image(const VectorField& coarse, const Level& full,
                                                Alignment alignment);

} // namespace hdmbench
