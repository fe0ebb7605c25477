#pragma once

#include "kernels/data/level.hpp"
#include "kernels/data/modulus.hpp"

#include <cstddef>
#include <limits>

/// The forces of tissues with laws of large strains (specification/laws), on the host: the same bits whatever
/// backend solves.
namespace hdmbench {

/// The cell that has kept least of its volume, or of its area in an image, at one of its Gauss points.
struct LeastVolume {
  double share = std::numeric_limits<double>::infinity();
  std::size_t site = 0; ///< the corner of the cell with the least coordinates
};

/// Sets `force` to what the tissues do to every site under a displacement, in the unit of sessions
/// (force_unit), 0 at prescribed components. Springs and loads are not in it. Returns the cell that has kept
/// least, of those whose corners are not all prescribed. A level without laws is linear everywhere.
LeastVolume law_forces(const Level& level, const ElasticModel& model, const VectorField& displacement,
                       VectorField& force);

} // namespace hdmbench
