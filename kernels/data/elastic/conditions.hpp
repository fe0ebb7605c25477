#pragma once

#include "kernels/data/level.hpp"

#include <vector>

namespace hdmbench {

/// A pixel whose modulus is a smaller share of the stiffest one's is void: added to it in float32 it changes
/// no bit, so nobody can have meant it to hold anything.
inline constexpr float void_share = 0x1p-24F;

/// A motion of a sheet that strains nothing, of small turns; pixels.
struct RigidMotion {
  double x = 0.0;
  double y = 0.0;
  double turn = 0.0;
  double column = 0.0; ///< about which it turns
  double row = 0.0;

  [[nodiscard]] double x_at(int site_row) const { return x - turn * (site_row - row); }
  [[nodiscard]] double y_at(int site_column) const { return y + turn * (site_column - column); }
};

/// Throws InputError where the elastic energy has no unique minimum on `level`, and says what is missing and
/// where: an image that is not at least 2 x 2, a sheet that can move or turn as a whole, or a part of it with
/// void around (void_share). Every part that prescribed sites cut off touches two of them and is held.
void require_held(const Level& level);

/// A displacement to begin with (pixels): the targets where a component is observed, means of them
/// elsewhere, of the nearer ones where there are any. The same bits whatever the number of threads. The level
/// is held.
[[nodiscard]] VectorField extended_conditions(const Level& level);

/// The motions without strain that prescribed components leave to the sheet.
[[nodiscard]] std::vector<RigidMotion> free_motions(const Level& level);

} // namespace hdmbench
