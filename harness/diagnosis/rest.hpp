#pragma once

#include "harness/scene.hpp"

#include <cstddef>

namespace hdmbench {

/// How far a field is from rest on the full resolution.
struct RestState {
  /// Way of each component to the minimum of its own energy, observation included, pixels.
  VectorField missing;
  double rms = 0.0; ///< sqrt(mean |missing|^2), pixels
  /// Sites that one more simultaneous sweep over the candidates would move, and those of them that a second
  /// one would move back to the bit. Rule::steps only, else 0.
  std::size_t moving = 0;
  std::size_t swapping = 0;
  /// Of missing: root mean square of the part that changes sign from column to column (x) or row to row (y),
  /// pixels, and its share of the whole, squared: 1 for stripes, 3/8 for noise, 0 for what is smooth.
  double stripes = 0.0;
  double stripes_share = 0.0;
};

/// `displacement` is finite and has the scene's extent.
[[nodiscard]] RestState measure_rest(const Scene& scene, const VectorField& displacement);

/// What `missing` adds up to: an estimate of the RMSD to the fixed point, pixels; good to a factor of three
/// where the material is nearly one. There a component is the mean of its neighbours and what is missing
/// obeys -(1/2 d_xx + 1/3 d_yy) = missing (y: the other way round), so that a wave of the number k grows by
/// 2.4 / k^2 on average over its directions. Waves of 2 s to 4 s pixels are what block means over s x s sites
/// keep and those over 2 s x 2 s lose. The longest wave is, along both axes, four times the distance of a
/// free site to the nearest condition. What is missing at observed components adds nothing up.
[[nodiscard]] double accumulated_distance(const Scene& scene, const VectorField& missing);

} // namespace hdmbench
