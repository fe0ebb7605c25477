#include "harness/check/rounding_bound.hpp"

#include "harness/check/energy_proofs.hpp"

namespace hdmbench {

EnergyBound energy_change_bound(const Level& level, const VectorField& displacement, int x, int y,
                                float step_x, float step_y) {
  return proofs_of(*level.energy).energy_change_bound(level, displacement, x, y, step_x, step_y);
}

} // namespace hdmbench
