#pragma once

#include "kernels/data/elastic/cell_kinds.hpp"
#include "kernels/data/elastic/hierarchy.hpp"

namespace hdmbench {

/// Sets ElasticLevel::response from the level's moments and masked cells: elastic_relaxation times the
/// inverse of a site's own 2 x 2 stiffness. `prescribed` is null but on the image, and its components do not
/// respond.
void set_response(ElasticLevel& level, const ElasticInFloat::PoissonRatio& ratio,
                  const Prescribed* prescribed);

} // namespace hdmbench
