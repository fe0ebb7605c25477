#pragma once

#include "kernels/data/level.hpp"

namespace hdmbench {

/// Whether rounding explains that a device answered otherwise than the specification at one site.
struct Certificate {
  bool holds = false;
  /// What separates the answers over what rounding can make of it, the larger of both components: of a
  /// candidate the energy by which it is dearer than another, of a minimiser its distance in pixels from the
  /// exact one. Infinite where the rule has no such answer.
  double gap_over_bound = 0.0;
};

/// The specification's answer to (x, y) of `before` in sweep `number` since the level was loaded: what scalar
/// computes.
struct SiteAnswer {
  float x = 0.0F;
  float y = 0.0F;
};
[[nodiscard]] SiteAnswer specified_answer(const Level& level, const VectorField& before, int number, int x,
                                          int y);

/// Judges `found`, which a device made of site (x, y) of `before` in sweep `number`. Without fault a device
/// computes each candidate's energy change to within the bound of bounded_energy.hpp, so what it chose cannot
/// be dearer than any other candidate by more than both bounds; the minimiser of closed form and correction
/// cannot be farther from the exact one than its bound. Where all arithmetic at the site is exact the bounds
/// are 0, and only the specified answer holds, ties included. Annealing is a random walk: its answers agree
/// to the bit or not at all.
[[nodiscard]] Certificate certify(const Level& level, const VectorField& before, int number, int x, int y,
                                  SiteAnswer found);

} // namespace hdmbench
