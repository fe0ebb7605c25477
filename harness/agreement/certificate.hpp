#pragma once

#include "kernels/level.hpp"

namespace hdmbench {

/// Whether rounding explains that a device answered otherwise than the specification at one site.
struct Certificate {
  bool holds = false;
  /// The energy (of a candidate) or the displacement (of a minimiser) that separates the answers, over what
  /// rounding can make of it; infinite where the device's answer is none that the rule can give.
  double gap_over_bound = 0.0;
};

/// Judges `found`, which a device made of site (x, y) of `before` in sweep `number` since the level was
/// loaded. The bound is derived per site (rounding_bound.hpp); where all arithmetic at the site is exact it
/// is 0, so that nothing but the specified answer holds, ties included.
[[nodiscard]] Certificate certify(const Level& level, const VectorField& before, int number, int x, int y,
                                  float found_x, float found_y);

} // namespace hdmbench
