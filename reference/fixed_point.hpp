#pragma once

#include "kernels/data/level.hpp"
#include "reference/interpolation.hpp"

#include <cstddef>

namespace hdmbench {

/// The field at which no site can lower its own energy U_t by any displacement: where ICM with ever finer
/// candidates ends. It depends on the level alone, not on a start, a schedule or a backend.
struct FixedPoint {
  ReferenceField displacement; ///< pixels
  std::size_t held = 0;        ///< components that the observation holds at their target
  int rounds = 0;              ///< linear systems solved per component until the held set was consistent
};

/// Half the derivative of (4.5) by d_t set to zero is one linear equation per site and component, a sparse
/// nonsymmetric M-matrix; a neighbour outside the image has the displacement of t and so drops out. A
/// component whose minimiser z without observation obeys A |y - z| <= K c / 2 is held at its target y (the
/// observation is an absolute value), any other observed one is pulled towards it by K c / 2A. Throws
/// InputError where a component is free everywhere in some part of the image, so that no unique field exists,
/// or where the held set does not settle.
[[nodiscard]] FixedPoint solve_fixed_point(const Level& level);

} // namespace hdmbench
