#pragma once

#include "kernels/data/level.hpp"
#include "reference/interpolation.hpp"

namespace hdmbench {

/// One simultaneous iteration in double: every site takes, per component, the first candidate of the smallest
/// energy, each energy evaluated directly from (4.6)-(4.17). Shares no arithmetic with kernels/; uses all
/// CPU threads. `displacement` has the level's extent.
[[nodiscard]] ReferenceField thesis_iteration(const Level& level, const ReferenceField& displacement);

/// Bilinear interpolation to the next level in double (Alg. 3, line 3); the outermost sites of both are at
/// the same place. No side is 0.
[[nodiscard]] ReferenceField thesis_prolongation(const ReferenceField& coarse, Extent fine);

} // namespace hdmbench
