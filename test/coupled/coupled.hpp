#pragma once

#include "kernels/data/level.hpp"

namespace hdmbench::test {

/// A second energy, that the library knows nothing of: what it asks of a level's energy is all there is.
extern const Energy coupled_energy;

/// The level with this energy and a coupling per site from a grid of quarters within -1/2 ... 1/2: the energy
/// is bounded from below, and dyadic levels stay exact.
void couple(Level& level);

} // namespace hdmbench::test
