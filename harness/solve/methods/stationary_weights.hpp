#pragma once

#include "kernels/data/level.hpp"

namespace hdmbench {

/// How much each component's equation g / A = ... counts in a sum of equations whose inner terms cancel: the
/// left null vector of the system without conditions, up to a factor. Per component, in MPa.
///
/// The system is not symmetric. Read as a random walk (a component is the mean of its neighbours with the
/// weights of g), the vector is the walk's stationary distribution: m in the inside of a material, another
/// value on the sites beside an interface. So it starts as m, and a few steps of the walk, each with half its
/// weight staying, settle the sites near interfaces; elsewhere nothing moves and nothing is computed.
[[nodiscard]] VectorField stationary_weights(const Level& level);

} // namespace hdmbench
