#pragma once

#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <array>
#include <cstdint>

namespace hdmbench {

/// Numbers of sites, by SiteKind.
using SiteCounts = std::array<std::int64_t, site_kinds>;

/// How many sites of each kind the level has that samples `full` (nearest modulus) at `extent`. Nothing as
/// large as the level is allocated.
[[nodiscard]] SiteCounts count_site_kinds(const Level& full, Extent extent, Alignment alignment);

} // namespace hdmbench
