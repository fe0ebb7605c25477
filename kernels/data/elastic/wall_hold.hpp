#pragma once

#include "kernels/data/level.hpp"

#include <array>
#include <cstddef>

namespace hdmbench {

/// How well walls hold a part of the tissue that slides along them. Their normals are taken from pixels and
/// err, so that a disc in a round hole cannot turn by them: what tells is the angle between the way of its
/// sites and the walls.
class WallHold {
public:
  /// Takes a site of a level that has walls: the components that a condition knows, or else its wall.
  void add(const Level& level, std::array<int, 3> place);
  /// Returns the least angle between walls and the way of the sites on them that a motion without strain
  /// makes, their root mean square, degrees; only motions that conditions leave count, and if there are none,
  /// or no walls, it is 90.
  [[nodiscard]] double least_angle() const;

private:
  static constexpr std::size_t unknowns = 6; ///< shifts along the axes and turns about them
  using Row = std::array<double, unknowns>;
  using Matrix = std::array<Row, unknowns>;

  static void add_product(const Row& first, const Row& second, double weight, Matrix& matrix);
  /// Whether all motions make an angle of more than that with the walls.
  [[nodiscard]] bool holds_at(double degrees) const;

  Matrix motion_{}; ///< the squares of the ways of the sites on walls, of each motion
  Matrix across_{}; ///< what of them is across their walls
  Matrix known_{};  ///< the squares of the ways along known components
};

/// How much normals of pixels err, degrees: the root mean square over an outline is up to 1.7
/// (WallNormals.WhatTheyAloneHoldIsRefused, WallNormals.OfPixelsAreThoseOfTheOutline).
inline constexpr double error_of_normals = 2.0;

/// Returns by how much of its way a motion that walls hold least can be off, as it meets them at an angle of
/// so many degrees (WallNormals.OfNearlyRoundWallsMatterAsMuchAsIsSaid).
[[nodiscard]] constexpr double largest_share_of_normals(double angle) {
  return error_of_normals / angle;
}

} // namespace hdmbench
