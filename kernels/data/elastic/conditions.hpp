#pragma once

#include "kernels/data/elastic/free_parts.hpp"
#include "kernels/data/level.hpp"

#include <vector>

namespace hdmbench {

/// Throws InputError where the elastic energy has no unique minimum on `level`, and says what is missing and
/// where: an image that is not at least 2 x 2, a sheet that can move or turn as a whole, or a part of it with
/// void around (free_parts.hpp). Every part that prescribed sites cut off touches two of them and is held.
void require_held(const Level& level);

/// The same of the sheet as a whole: `hold` has all its conditions.
void require_held(Extent image, const Hold& hold);

/// A displacement to begin with (pixels): the targets where a component is observed, means of them
/// elsewhere, of the nearer ones where there are any. The same bits whatever the number of threads. The level
/// is held.
[[nodiscard]] VectorField extended_conditions(const Level& level);

/// A component on a level of averages: what is known of it and how well, 0 ... 1.
struct Known {
  Extent extent;
  std::vector<float> value;
  std::vector<float> weight;

  explicit Known(Extent extent_) : extent(extent_), value(extent_.sites()), weight(extent_.sites()) {}
};

// The steps of extended_conditions(), for who has a part of the image.
[[nodiscard]] Known known_component(Extent extent, const std::vector<float>& target,
                                    const std::vector<float>& confidence);
/// The mean over the 3 x 3 sites around each second one, nearer ones counting more.
[[nodiscard]] Known averaged(const Known& fine);
/// What `fine` does not know well enough comes from its averages.
void fill(Known& fine, const Known& coarse);
/// All of it: by averages of averages, until there are no more than 2 x 2.
void extend(Known& known);

/// The motions without strain that prescribed components leave to the sheet.
[[nodiscard]] std::vector<RigidMotion> free_motions(const Level& level);

} // namespace hdmbench
