#pragma once

#include "reference/finite_elements.hpp"

#include <array>
#include <vector>

namespace hdmbench {

/// Fibres of the nodes' tissues.
struct ReferenceFibres {
  std::array<std::vector<double>, 3> direction; ///< unit vectors
  std::vector<double> modulus;                  ///< in the unit of the problem's; 0: none
  std::vector<bool> tension_only;
};

/// The displacement of a body of neo-Hookean or stiffening tissues (kernels/specification/laws), in double,
/// by Newton's method with assembled tangents, the load in so many parts: written from the energies, without
/// a line of the kernels. A load that is taken whole may lead to another balance than one that grows, if the
/// method strays; so in one part it must not, and throws. `stiffening` has a number per node, as
/// Level::stiffening. Where walls are, all of an element with a node in void (a modulus below 2^-24 of the
/// stiffest) is void. `fibres`: null where there are none. Throws InputError as solve_finite_elements does,
/// and where Newton's method does not come to an end, or to a balance that the body would leave.
[[nodiscard]] ReferenceField solve_large_strains(const ElasticProblem& problem,
                                                 const std::vector<double>& stiffening, double poisson,
                                                 int parts, const ReferenceFibres* fibres = nullptr);

} // namespace hdmbench
