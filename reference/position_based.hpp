#pragma once

#include "reference/finite_elements.hpp"

#include <vector>

namespace hdmbench {

/// The displacement of the body of solve_large_strains() by position-based dynamics with compliance (XPBD),
/// as games and simulators of surgery have it, after so many sweeps from the undeformed body, in double: a
/// rival. One sweep a time step, a constraint for each quadrature point, which is the root of its energy;
/// conditions and loads come during the first quarter of the sweeps. Masses go with moduli, as only the end
/// is wanted. The larger the step the sooner it rests, and the farther from the truth: the step here is a
/// good one of two orders of magnitude, and leaves some percent. Throws InputError as solve_finite_elements
/// does for what is no body, and for springs, which it has not.
[[nodiscard]] ReferenceField relax_positions(const ElasticProblem& problem,
                                             const std::vector<double>& stiffening, double poisson,
                                             int sweeps);

} // namespace hdmbench
