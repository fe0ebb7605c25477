#pragma once

#include "kernels/data/elastic/free_parts.hpp"
#include "kernels/data/level.hpp"

#include <vector>

namespace hdmbench {

/// Throws InputError where the elastic energy has no unique minimum on `level`, and says what is missing and
/// where: an image that is not at least 2 x 2, a sheet that can move or turn as a whole, or a part of it with
/// void around (free_parts.hpp). Every part that prescribed sites cut off touches two of them and is held.
void require_held(const Level& level);

/// A displacement to begin with (pixels): the targets where a component is observed, means of them
/// elsewhere, of the nearer ones where there are any. The same bits whatever the number of threads. The level
/// is held.
[[nodiscard]] VectorField extended_conditions(const Level& level);

/// The motions without strain that prescribed components leave to the sheet.
[[nodiscard]] std::vector<RigidMotion> free_motions(const Level& level);

} // namespace hdmbench
