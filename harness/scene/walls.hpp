#pragma once

#include "kernels/data/level.hpp"

#include <array>
#include <optional>
#include <vector>

namespace hdmbench {

/// Returns which sites are `solid` or bumps: of one pixel, in no cell without solid corners, or specks of a
/// few cells that at most an edge or a corner joins to others. Tissue does not hold them. Sites that a
/// condition knows stay as they are, and so do the cells around them.
[[nodiscard]] std::vector<bool> with_bumps(const std::vector<bool>& solid, const Level& level);

/// Makes the outline of the sites that are `solid` a wall: they become void (modulus 0), and the sites
/// beside them slide along it, held by springs along its normal alone (stiffness_of_walls). Those that
/// share no cell with tissue are held where they are, so that what a wall is made of stays. `shape` is what
/// normals are of: all that is solid, and its openings, so that a wall does not turn at their rims. Both
/// have one for each site; `step` is the way from a site to the next along each axis, pixels. `normals` has
/// those that are known better, of any length, 0 where none is; empty: nowhere. Others are of the shape
/// within `radius` pixels; where that is not said 9, of long pixels up to 18, of what is thin 4. No effect
/// where nothing is solid.
void set_wall(const std::vector<bool>& solid, const std::vector<bool>& shape,
              const std::array<double, 3>& step, Level& level, const VectorField& normals = {},
              std::optional<double> radius = std::nullopt);

/// Returns the least and the greatest radius, pixels, by which normals along a wall can be told: nearer
/// stairs of pixels have no slope, farther the other side of what slides is seen.
[[nodiscard]] std::array<double, 2> limits_of_normal_radius(const std::vector<bool>& solid, Extent extent,
                                                            const std::array<double, 3>& step);

/// By how much the normals of walls turn where they look farther.
struct TurnOfNormals {
  double radius = 0.0;  ///< pixels: how far they look by themselves
  double farther = 0.0; ///< pixels: twice as far, or as far as what slides is thick
  double degrees = 0.0; ///< the root mean square over the wall
};
/// Stairs of a smooth outline turn normals by a few degrees, notches, bumps and edges by many: these hold
/// what slides, or do not, by how far normals look. The level has the wall that set_wall() made of the same,
/// with usual normals.
[[nodiscard]] TurnOfNormals turn_of_normals(const std::vector<bool>& solid, const std::vector<bool>& shape,
                                            const std::array<double, 3>& step, const Level& level);

/// Moves the targets of all sites that slide as set_rest_on_wall() does; after all else is said of them.
void set_rest_on_walls(Level& level);

/// How sites that slide were held.
struct WallReport {
  std::size_t sites = 0; ///< that slide
  double gave_way = 0.0; ///< pixels: the most that one went across its wall
};

/// Returns what became of the walls of a level under a displacement, pixels.
[[nodiscard]] WallReport walls_under(const Level& level, const VectorField& displacement);

} // namespace hdmbench
