#pragma once

#include "kernels/data/field.hpp"
#include "kernels/data/level.hpp"

#include <cstddef>
#include <functional>
#include <optional>

namespace hdmbench {

/// Returns the site of tissue that moves most.
[[nodiscard]] std::size_t farthest(const Level& level, const VectorField& motion);

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
/// most in it; none where no such motion was found. It ends after a few steps where all that they meet is
/// stiff, else after `most`, of which each takes a force and a cycle.
[[nodiscard]] std::optional<std::size_t> site_that_buckles(const BalancedBody& body, int most);

} // namespace hdmbench
