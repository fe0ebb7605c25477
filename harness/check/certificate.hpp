#pragma once

#include "kernels/data/level.hpp"

#include <optional>
#include <string>

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
/// be dearer than any other candidate by more than both bounds; the minimiser of closed form
/// cannot be farther from the exact one than its bound. Where all arithmetic at the site is exact the bounds
/// are 0, and only the specified answer holds, ties included. Annealing is a random walk: its answers agree
/// to the bit or not at all.
[[nodiscard]] Certificate certify(const Level& level, const VectorField& before, int number, int x, int y,
                                  SiteAnswer found);

/// Largest possible error of the float32 energy change U_t(d_t + step) - U_t(d_t) that a device computes at
/// one site, per component, in the unit of the energy.
struct EnergyBound {
  double x = 0.0;
  double y = 0.0;
};

/// Running error analysis (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., section
/// 3.3) of kernels/specification/energy.inc itself: the file is compiled with a scalar that carries, beside
/// its float value, a bound of its distance from exact arithmetic on the same displacements, targets,
/// confidences and moduli. An operation adds unit roundoff times its result; 1 / m enters with the rounding
/// of the host. So whatever changes in the specification changes in the bound.
[[nodiscard]] EnergyBound energy_change_bound(const Level& level, const VectorField& displacement, int x,
                                              int y, float step_x, float step_y);

/// An operation of a sweep that float32 does not hold whatever the order of operations.
struct InexactOperation {
  int x = 0;
  int y = 0;
  int sweep = 0;      ///< since the level was loaded, from 0
  char operation = 0; ///< + - * /, < for any comparison, = for an input or constant out of range
  float left = 0.0F;  ///< operands
  float right = 0.0F;
  double magnitude = 0.0; ///< no partial sum, in whatever order, is larger than this ...
  double quantum = 0.0;   ///< ... and all are multiples of this power of two; infinite for 0

  /// "x = 3, y = 4, sweep 0: 24 * -0.1: terms of up to 2.4 in units of 2^-24 need 26 bits, float32 has 24".
  [[nodiscard]] std::string text() const;
};

/// Proves that sweep `number` of `level` over `before` is exact in float32, at every site and for every
/// candidate, chosen or not; else the first operation that is not, sites in raster order. With it no
/// contraction into fused multiply-adds and no regrouping by the laws of a ring (sums and products reordered,
/// distributed or factored out) can change a bit, nor can a device that flushes subnormal numbers.
///
/// energy.inc and update.inc are compiled with a scalar that carries, beside its float, a magnitude M and a
/// quantum Q, a power of two: an input has |value| and its lowest set bit, a product M_a M_b and Q_a Q_b, a
/// sum M_a + M_b and min(Q_a, Q_b). By induction everything that an expression can be put together from is a
/// multiple of Q and at most M; where M <= 2^24 Q, a float holds it. What a common factor is taken out of
/// only gains by that, since a factor is at least its own quantum. M itself is right in double: a product has
/// 48 bits at most, and a sum of more than 53 exceeds 2^24 Q however it is rounded. All M and Q, inputs
/// included, lie within 2^-30 ... 2^30, whence any part of a product of up to seven factors, as many as there
/// are, lies within 2^-120 ... 2^120. To check the induction itself, every operation is also done in float
/// and in double, and compared. Comparisons are judged as the sign of a difference, as the hardware of the
/// thesis compares. 1 / m, which the host rounds, must be exact.
///
/// Only Rule::steps can be exact: closed form needs 1 / A, and no A, a sum of six squares of
/// 1 + 2^k with k from -5 to 5, is a power of two; the random numbers of annealing are multiples of 1 / 4093.
/// `before` has the extent of the level, whose update is not sequential (its sites see others that have
/// moved).
[[nodiscard]] std::optional<InexactOperation> first_inexact(const Level& level, const VectorField& before,
                                                            int number);

/// What is known of an energy's arithmetic beyond its bits: energy_proofs.cpp compiles the energy with other
/// scalars. Each is described above, where the function of the same name is declared.
struct EnergyProofs {
  SiteAnswer (*specified_answer)(const Level& level, const VectorField& before, int number, int x, int y);
  /// As specified_answer, of a device that fuses every product into the sum that follows.
  SiteAnswer (*fused_answer)(const Level& level, const VectorField& before, int number, int x, int y);
  Certificate (*certify)(const Level& level, const VectorField& before, int number, int x, int y,
                         SiteAnswer found);
  EnergyBound (*energy_change_bound)(const Level& level, const VectorField& displacement, int x, int y,
                                     float step_x, float step_y);
  std::optional<InexactOperation> (*first_inexact)(const Level& level, const VectorField& before, int number);
};

[[nodiscard]] const EnergyProofs& proofs_of(const Energy& energy);

} // namespace hdmbench
