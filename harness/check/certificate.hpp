#pragma once

#include "kernels/data/level.hpp"

#include <array>
#include <optional>
#include <string>

namespace hdmbench {

/// Whether rounding explains that a device answered otherwise than the specification at one site.
struct Certificate {
  bool holds = false;
  /// What separates the answers over what rounding can make of it, the largest of all components: of a
  /// candidate the energy by which it is dearer than another, of a minimiser its distance in pixels from the
  /// exact one. Infinite where the rule has no such answer.
  double gap_over_bound = 0.0;
};

/// An answer to one site by axis, pixels; of an image z is 0.
using SiteAnswer = std::array<float, 3>;

/// An operation of a sweep that float32 does not hold whatever the order of operations.
struct InexactOperation {
  char operation = 0; ///< + - * /, < for any comparison, = for an input or constant out of range
  float left = 0.0F;  ///< operands
  float right = 0.0F;
  double magnitude = 0.0; ///< no partial sum, in whatever order, is larger than this ...
  double quantum = 0.0;   ///< ... and all are multiples of this power of two; infinite for 0
  std::string place{};    ///< Extent::place() of the site
  int sweep = 0;          ///< since the level was loaded, from 0

  /// "x = 3, y = 4, sweep 0: 24 * -0.1: terms of up to 2.4 in units of 2^-24 need 26 bits, float32 has 24".
  [[nodiscard]] std::string text() const;
};

/// What is known of an energy's arithmetic beyond its bits: energy_proofs.cpp compiles the energy with other
/// scalars, for images (z = 0) and volumes. `number` counts the sweeps since the level was loaded, `before`
/// has the extent of the level.
struct EnergyProofs {
  /// The specification's answer to (x, y, z) of `before` in sweep `number`: what scalar computes.
  SiteAnswer (*specified_answer)(const Level& level, const VectorField& before, int number, int x, int y,
                                 int z);

  /// The same with the rewrites of the rewritten::Replay that lives in this thread (rewritten_real.hpp).
  SiteAnswer (*replayed_answer)(const Level& level, const VectorField& before, int number, int x, int y,
                                int z);

  /// Judges `found`, which a device made of site (x, y, z) of `before` in sweep `number`. Without fault a
  /// device computes each candidate's energy change to within its bound, so what it chose cannot be dearer
  /// than any other candidate by more than both bounds; the minimiser of closed form cannot be farther from
  /// the exact one than its bound. Where all arithmetic at the site is exact the bounds are 0, and only the
  /// specified answer holds, ties included. Annealing is a random walk: its answers agree to the bit or not
  /// at all.
  Certificate (*certify)(const Level& level, const VectorField& before, int number, int x, int y, int z,
                         const SiteAnswer& found);

  /// Proves that sweep `number` of `level` over `before` is exact in float32, at every site and for every
  /// candidate, chosen or not; else the first operation that is not, sites in raster order. With it no
  /// contraction into fused multiply-adds and no regrouping by the laws of a ring (sums and products
  /// reordered, distributed or factored out) can change a bit, nor can a device that flushes subnormal
  /// numbers. The scalar that proves it is proven_real.hpp. Comparisons are judged as the sign of a
  /// difference, as the hardware of the thesis compares. 1 / m, which the host rounds, must be exact.
  ///
  /// Only Rule::steps can be exact: closed form needs 1 / A, and in an image no A, a sum of six squares of 1
  /// + 2^k with k from -5 to 5, is a power of two; the random numbers of annealing are multiples of 1 / 4093.
  /// The level's update is not sequential (its sites see others that have moved).
  std::optional<InexactOperation> (*first_inexact)(const Level& level, const VectorField& before, int number);
};

/// Returns the proofs for the energy that the level has.
[[nodiscard]] const EnergyProofs& proofs_of(const Level& level);

} // namespace hdmbench
