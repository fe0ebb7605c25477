#pragma once

#include "kernels/level.hpp"
#include "kernels/pyramid.hpp"

#include <array>
#include <cstdint>

/// What one site update of energy.inc by Rule::steps takes at the least, whoever computes it: the yardstick
/// of every percentage of a ceiling. test/cost_test.cpp counts the operations in energy.inc itself.
namespace hdmbench {

/// Which numbers of a site are the same as its neighbours', or not there.
enum class SiteKind {
  general,           ///< observed in a component, the moduli around it differ
  unobserved,        ///< both confidences are 0: no term of the observation is left
  uniform,           ///< all nine moduli are equal: the stiffness ratios and curvatures are constants
  uniform_unobserved ///< both
};
inline constexpr std::size_t site_kinds = 4;

/// Arithmetic of one update: float additions, subtractions, multiplications, absolute values and comparisons,
/// each one operation, as energy.inc writes them: what occurs twice counts once, what is the same at all
/// sites (candidates, K; with uniform moduli ratios and curvatures) is done once for all and counts nothing,
/// nor does what is multiplied by a confidence of 0.
struct SiteCost {
  int fixed;
  int per_candidate;

  [[nodiscard]] constexpr int operations(int candidates) const { return fixed + per_candidate * candidates; }
};

/// By SiteKind. The first candidate is compared with nothing, which `fixed` makes up for.
inline constexpr std::array<SiteCost, site_kinds> site_costs{{{109, 18}, {103, 8}, {78, 16}, {72, 6}}};

[[nodiscard]] constexpr const SiteCost& site_cost(SiteKind kind) {
  return site_costs[static_cast<std::size_t>(kind)];
}

/// Numbers of sites, by SiteKind.
using SiteCounts = std::array<std::int64_t, site_kinds>;

/// How many sites of each kind the level has that samples `full` (nearest modulus) at `extent`. Nothing as
/// large as the level is allocated.
[[nodiscard]] SiteCounts count_site_kinds(const Level& full, Extent extent, Alignment alignment);

} // namespace hdmbench
