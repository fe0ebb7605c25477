#pragma once

#include "harness/ranks/elastic_share.hpp"
#include "kernels/data/elastic/hierarchy_part.hpp"

#include <optional>

namespace hdmbench {

/// The finest level that is not cut, from the cells that ranks have made of it, and all below it; on the
/// first rank, none on the others. `part`: of this rank; without levels where it has no piece. Collective.
[[nodiscard]] std::optional<ElasticHierarchy> gather_coarse_levels(const ElasticPart& part,
                                                                   const ElasticShare& share,
                                                                   const ElasticInFloat::PoissonRatio& ratio,
                                                                   Ranks& ranks);

} // namespace hdmbench
