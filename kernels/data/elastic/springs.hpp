#pragma once

#include "kernels/data/level.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace hdmbench {

/// How stiff the spring is that pulls a component to its target, in MPa times the thickness of the sheet, for
/// a confidence above 0 and below 1: at 1/2 as stiff as the tissue of its site, so that an observation of
/// confidence c and the tissue around share the way between them about as c to 1 - c. From
/// 1 on a component is prescribed.
[[nodiscard]] inline double spring_stiffness(float modulus, float confidence) {
  const auto share = static_cast<double>(confidence);
  return static_cast<double>(modulus) * share / (1.0 - share);
}

/// Returns the place of an entry of a symmetric matrix of so many axes, which is kept row by row from its
/// diagonal on.
[[nodiscard]] constexpr std::size_t symmetric_entry(std::size_t axes, std::size_t row, std::size_t column) {
  const std::size_t first = row < column ? row : column;
  return first * axes - first * (first + 1) / 2 + (row < column ? column : row);
}

/// A spring at every site that pulls it back to where it is at rest, in MPa times the thickness of the sheet,
/// or the side of a voxel. Its force is minus this times the way, so it may hold one direction more than
/// another, as an edge of a picture does: symmetric and positive semidefinite.
struct SiteSprings {
  SiteSprings() = default; ///< none
  explicit SiteSprings(Extent extent)
      : entries(extent.axes() * (extent.axes() + 1) / 2, std::vector<float>(extent.sites())) {}

  std::vector<std::vector<float>> entries; ///< symmetric_entry() of all sites; no entries: no springs
};

/// Returns the confidence of an observation with a standard deviation of so many pixels, >= 0: its spring is
/// 1 / deviation^2 times as stiff as the tissue of its site. In millimetres: modulus * pixel / deviation^2,
/// the pixel being its area, or volume. So pixels that are halved, and observed each, pull as before.
[[nodiscard]] inline float confidence_of_deviation(double deviation) {
  return static_cast<float>(1.0 / (1.0 + deviation * deviation));
}

[[nodiscard]] inline bool is_spring(float confidence) {
  return confidence > 0.0F && confidence < 1.0F;
}

/// Returns how many times the modulus of its site a spring is, of a confidence that is_spring(); else 0.
[[nodiscard]] inline double weight_of_confidence(float confidence) {
  return is_spring(confidence) ? spring_stiffness(1.0F, confidence) : 0.0;
}

/// Returns the confidence of a spring that is so many times, > 0, its site's modulus; below 1.
[[nodiscard]] inline float confidence_of_weight(double weight) {
  return std::min(static_cast<float>(weight / (1.0 + weight)), std::nextafter(1.0F, 0.0F));
}

/// How many times as stiff as its tissue the spring is that keeps a site on a wall along which it slides. It
/// gives way by a few thousandths of a pixel where strains are small; stiffer ones take more steps
/// (Walls.StifferOnesTakeMoreSteps).
inline constexpr float stiffness_of_walls = 100.0F;

/// Returns an entry of what pulls a site by direction, an observation and a wall, over the modulus of the
/// site.
[[nodiscard]] inline double entry_by_direction(const Level& level, std::size_t at, std::size_t row,
                                               std::size_t column) {
  const std::size_t entry = symmetric_entry(level.extent.axes(), row, column);
  return (level.springs.empty() ? 0.0 : double{level.springs[entry][at]}) +
         (level.walls.empty() ? 0.0 : double{level.walls[entry][at]});
}

[[nodiscard]] inline bool has_springs_by_direction(const Level& level) {
  return !level.springs.empty() || !level.walls.empty();
}

/// Returns whether the site slides along a wall.
[[nodiscard]] inline bool is_on_wall(const Level& level, std::size_t at) {
  bool is_on_one = false;
  for (std::size_t axis = 0; !level.walls.empty() && axis < level.extent.axes(); ++axis) {
    is_on_one = is_on_one || level.walls[symmetric_entry(level.extent.axes(), axis, axis)][at] > 0.0F;
  }
  return is_on_one;
}

/// Returns an entry of the spring of a site, by components and by direction, MPa times the thickness of the
/// sheet, or the side of a voxel.
[[nodiscard]] inline double spring_entry(const Level& level, std::size_t at, std::size_t row,
                                         std::size_t column) {
  const double by_direction = double{level.modulus.values[at]} * entry_by_direction(level, at, row, column);
  const float confidence = level.confidence[row][at];
  return by_direction + (row == column && is_spring(confidence)
                             ? spring_stiffness(level.modulus.values[at], confidence)
                             : 0.0);
}

/// Returns the component of what the spring of a site does about a way from where it is at rest; way(axis).
template <typename Way>
[[nodiscard]] double spring_force(const Level& level, std::size_t at, std::size_t component, const Way& way) {
  double force = 0.0;
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    const double entry = spring_entry(level, at, component, axis);
    force += entry == 0.0 ? 0.0 : entry * way(axis);
  }
  return force;
}

/// Returns where the springs of a site are at rest together, those by direction and those of confidences.
/// `pull` is the sum of each one, over the modulus of the site, times where it alone would be at rest. A
/// component that is prescribed, and a direction that no spring holds, is where `otherwise` has it. Pixels.
[[nodiscard]] std::array<double, 3> rest_of_springs(const Level& level, std::size_t at,
                                                    std::array<double, 3> pull,
                                                    const std::array<double, 3>& otherwise);

/// Moves the target of a site of `level` to where its wall and what is observed of it are at rest together:
/// an observation pulls nothing through a wall. What is not observed rests at 0.
void set_rest_on_wall(Level& level, std::size_t at);

[[nodiscard]] inline bool has_springs(const Level& level) {
  return has_springs_by_direction(level) ||
         std::ranges::any_of(level.confidence.planes, [](const std::vector<float>& component) {
           return std::ranges::any_of(component, is_spring);
         });
}

} // namespace hdmbench
