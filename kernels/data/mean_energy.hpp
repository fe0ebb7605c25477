#pragma once

#include "kernels/data/level.hpp"

namespace hdmbench {

/// U = (1/|S|) * sum of U_t (5.2): each site's energy in float as the kernels define it, summed in double in
/// raster order, so the figure does not depend on threads or devices.
[[nodiscard]] double mean_energy(const Level& level, const VectorField& displacement);

} // namespace hdmbench
