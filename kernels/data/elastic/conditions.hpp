#pragma once

#include "kernels/data/level.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

/// Whether conditions say all of where a site goes.
[[nodiscard]] inline bool is_prescribed(const Level& level, std::size_t site) {
  return std::ranges::all_of(std::span(level.confidence.planes).first(level.extent.axes()),
                             [&](const std::vector<float>& component) { return component[site] >= 1.0F; });
}

/// A pixel whose modulus is a smaller share of the stiffest one's is void: added to it in float32 it changes
/// no bit, so nobody can have meant it to hold anything.
inline constexpr float void_share = 0x1p-24F;

/// Returns the modulus below which a pixel of the level is void.
[[nodiscard]] float void_modulus(const Level& level);

/// Returns whether a pixel is void.
[[nodiscard]] bool has_void(const Level& level);

/// Gives what was void below `least`, as in another level, so small a modulus that it is void in this one,
/// whose stiffest tissue may be another.
void keep_void(float least, Level& level);

/// Returns whether void may cut tissue into teeth or sheets: it has not come with walls.
[[nodiscard]] inline bool is_cut_by_void(const Level& level) {
  return !level.has_walls && has_void(level);
}

/// A volume's Poisson's ratio beyond it leaves float32 no digits for what is not a change of size.
inline constexpr double largest_volume_poisson = 0.4999;

/// Squares of moduli that differ more do not fit into float32, on whatever scale: what is soft is anywhere.
inline constexpr double most_contrast = 1e30;

/// A part whose surroundings have a smaller share of the largest modulus floats where no condition holds it:
/// what they do to it are the last digits of forces between its own sites, and float32 loses them.
inline constexpr float floating_share = 1e-5F;

/// A motion of a sheet or a body that strains nothing, of small turns; pixels.
struct RigidMotion {
  std::array<double, 3> shift{};                ///< of each component at its own place below
  std::array<double, 3> turn{};                 ///< about x, y and z; of a sheet about z
  std::array<std::array<double, 3>, 3> about{}; ///< by component: the site that turns do not move
  std::array<double, 3> sides{1.0, 1.0, 1.0};   ///< Level::sides

  /// How far the component `axis` of a site moves.
  [[nodiscard]] double at(std::size_t axis, const std::array<int, 3>& site) const {
    const std::size_t next = (axis + 1) % 3;
    const std::size_t last = (axis + 2) % 3;
    const auto way = [&](std::size_t along) { return sides[along] * (site[along] - about[axis][along]); };
    return shift[axis] + (turn[next] * way(last) - turn[last] * way(next));
  }
};

/// Throws InputError where the elastic energy has no unique minimum on `level` that float32 can find, and
/// says what is missing and where: moduli that differ by more than most_contrast, an image that is not at
/// least 2 x 2, a sheet that can move or turn as a whole, or a part of it with void around (void_share).
/// Every part that prescribed sites cut off touches two of them and is held.
void require_held(const Level& level);

/// Parts of the tissue of a few sites each, with void around.
struct Specks {
  std::size_t parts = 0;
  std::vector<std::size_t> sites{}; ///< of all of them
};
/// Fewer sites than so many are a speck, three along each axis.
[[nodiscard]] constexpr int fewest_sites_of_part(std::size_t axes) {
  return axes == 3 ? 27 : 9;
}
/// Returns the specks of a level of which no condition, wall or spring knows anything; none where there is
/// no other tissue.
[[nodiscard]] Specks loose_specks(const Level& level);

/// Says which part of the tissue floats (floating_share), in words; empty: none does.
[[nodiscard]] std::string floating_part(const Level& level);

/// Returns the least angle to its walls that any part of the tissue can go at (WallHold), degrees; without
/// walls 90.
[[nodiscard]] double least_angle_to_walls(const Level& level);

/// Below so many degrees walls that hold tissue alone hold it little: a quarter of its way is that of the
/// errors of normals from pixels, and solutions move it last.
inline constexpr double least_firm_angle = 8.0;
/// Returns whether walls hold a part of the tissue at less than that.
[[nodiscard]] inline bool is_loose_in_walls(const Level& level) {
  return level.has_walls && least_angle_to_walls(level) < least_firm_angle;
}

/// A displacement to begin with (pixels): the targets where a component is observed, means of them
/// elsewhere, of the nearer ones where there are any. The same bits whatever the number of threads. The level
/// is held.
[[nodiscard]] VectorField extended_conditions(const Level& level);

/// The motions without strain that prescribed components leave: at most three of a sheet, six of a body.
[[nodiscard]] std::vector<RigidMotion> free_motions(const Level& level);

} // namespace hdmbench
