#pragma once

#include "kernels/data/elastic/hierarchy.hpp"

#include <vector>

namespace hdmbench {

/// What ElasticHierarchy::coarsest_inverse is of `level`: a symmetric generalised inverse of its stiffness.
/// Functions that others make up for, or that nothing resists, stay 0. `prescribed` may be empty: per
/// component, not 0 where it may not move.
[[nodiscard]] std::vector<float> coarsest_inverse(const ElasticLevel& level,
                                                  const ElasticInFloat::PoissonRatio& ratio,
                                                  const std::vector<std::uint8_t>& prescribed);

} // namespace hdmbench
