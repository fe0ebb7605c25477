#pragma once

#include "reference/finite_elements.hpp"

#include <vector>

namespace hdmbench {

/// The displacement of a body of neo-Hookean or stiffening tissues (kernels/specification/laws), in double,
/// by Newton's method with assembled tangents, the load in so many parts: written from the energies, without
/// a line of the kernels. `stiffening` has a number per node, as Level::stiffening. Where springs couple
/// components, as walls do, all of an element with a node in void (a modulus below 2^-24 of the stiffest) is
/// void. Throws InputError as solve_finite_elements does, and where Newton's method does not come to an end.
[[nodiscard]] ReferenceField solve_large_strains(const ElasticProblem& problem,
                                                 const std::vector<double>& stiffening, double poisson,
                                                 int parts);

} // namespace hdmbench
