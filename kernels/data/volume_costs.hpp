#pragma once

#include "kernels/data/energy.hpp"

namespace hdmbench {

/// Operations of a site of a volume by the thesis's energy, by SiteKind, as Energy::costs has those of an
/// image.
inline constexpr std::array<SiteCost, site_kinds> thesis_costs_in_volumes{
    {{444, 27}, {435, 12}, {333, 24}, {324, 9}}};

} // namespace hdmbench
