#pragma once

#include "kernels/data/field.hpp"
#include "kernels/data/level.hpp"

#include <array>
#include <cstddef>
#include <functional>
#include <optional>

namespace hdmbench {

/// Returns the site of tissue that moves most.
[[nodiscard]] std::size_t farthest(const Level& level, const VectorField& motion);

/// After so many steps a body that buckles as a whole has been met as soft.
inline constexpr int fewest_steps_to_buckling = 4;

/// What a body with laws of large strains does, as conjugate gradients know it.
struct BalancedBody {
  const Level& level;
  const VectorField& displacement; ///< pixels; what is left to be balanced under it is `residual`
  const VectorField& residual;
  /// Sets the second field to what is left to be balanced under the first one.
  std::function<void(const VectorField&, VectorField&)> residual_of;
  /// Sets the second field to what a cycle makes of the first one, a residual.
  std::function<void(const VectorField&, VectorField&)> correct;
};

/// Looks for a motion in which forces push the body on, by steps of conjugate gradients on its tangent: for a
/// balance that it would leave, as a column does that is pressed beyond Euler's load. A solver may find that
/// balance all the same, where nothing tells the column to which side to bend. Returns the site that moves
/// most in it; none where no such motion was found. It ends after `fewest` steps where all that they meet is
/// stiff, else after `most`, of which each takes a force and a cycle.
[[nodiscard]] std::optional<std::size_t> site_that_buckles(const BalancedBody& body, int most,
                                                           int fewest = fewest_steps_to_buckling);

/// Returns the middle of where thin layers of tissue with softer tissue beside them are pressed so far that
/// they may wrinkle, which coarser images do not show; none: nowhere. That is by .8 of what a stiff film on a
/// deep base bears, a quarter of (3 soft / stiff)^(2/3) (Allen 1969), through a block of 8 sites a side. Void
/// is no softer tissue. The displacement is in pixels.
[[nodiscard]] std::optional<std::array<int, 3>> place_that_may_wrinkle(const Level& level,
                                                                       const VectorField& displacement);

} // namespace hdmbench
