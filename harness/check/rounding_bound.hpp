#pragma once

#include "kernels/data/level.hpp"

namespace hdmbench {

/// Largest possible error of the float32 energy change U_t(d_t + step) - U_t(d_t) that a device computes at
/// one site, per component, in the unit of the energy.
struct EnergyBound {
  double x = 0.0;
  double y = 0.0;
};

/// Running error analysis (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., section
/// 3.3) of kernels/specification/energy.inc itself: the file is compiled with a scalar that carries, beside
/// its float value, a bound of its distance from exact arithmetic on the same displacements, targets,
/// confidences and moduli. An operation adds unit roundoff times its result; 1 / m enters with the rounding
/// of the host. So whatever changes in the specification changes in the bound.
[[nodiscard]] EnergyBound energy_change_bound(const Level& level, const VectorField& displacement, int x,
                                              int y, float step_x, float step_y);

} // namespace hdmbench
