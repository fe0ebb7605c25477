#pragma once

#include "kernels/data/level.hpp"

#include <cstdint>
#include <vector>

namespace hdmbench {

/// A part of an image: sites x ... x + extent.width - 1 of rows y ... y + extent.height - 1.
struct Window {
  int x = 0;
  int y = 0;
  Extent extent;

  bool operator==(const Window&) const = default;
};

/// Which parts of a large level are looked at.
struct WindowPlan {
  int windows = 8; ///< at most, >= 1
  int side = 128;  ///< sites, >= 1; less where the image has less than two of them
  std::uint64_t seed = 0;
};

/// Disjoint windows: the four corners with their borders, one on an interface between moduli, else on an
/// observed site away from the borders, where there is one, the others anywhere. In this order, as many as
/// are wanted and have room. The same on every machine.
[[nodiscard]] std::vector<Window> choose_windows(const Level& level, const WindowPlan& plan);

/// `inner` and all that can have an influence on it in `sweeps` sweeps, a site a sweep, within the image. It
/// begins at even column and row, so that colours stay what they are. A border of the image is one of the
/// window too, and so is its rule; a cut is wrong no deeper than `sweeps` sites.
[[nodiscard]] Window with_influence(const Window& inner, int sweeps, Extent image);

/// The level or field of the window only. Random numbers (Rule::annealing) belong to the place in the image
/// and would be others.
[[nodiscard]] Level crop(const Level& level, const Window& window);
[[nodiscard]] VectorField crop(const VectorField& field, const Window& window);

} // namespace hdmbench
