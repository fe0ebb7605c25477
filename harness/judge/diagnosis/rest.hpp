#pragma once

#include "harness/scene/scene.hpp"

#include <cstddef>

namespace hdmbench {

/// How far a field is from rest on the full resolution.
struct RestState {
  /// Distance of each component from the minimum of its own energy, observation included, pixels, signed.
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

/// An estimate of the RMSD to the fixed point from RestState::missing, pixels; good to a factor of three
/// where the moduli are nearly equal. There a component is the mean of its neighbours, and its error d obeys
/// -(1/2 d_xx + 1/3 d_yy) = missing (y: the other way round). So a wave of the wave number k in `missing` is
/// amplified by 2.4 / k^2, on average over its directions. Waves of 2 s to 4 s pixels are what block means
/// over s x s sites keep and those over 2 s x 2 s lose. The longest wave is, along both axes, four times the
/// largest distance of a free site from the nearest condition. Observed components are not amplified.
[[nodiscard]] double accumulated_distance(const Scene& scene, const VectorField& missing);

} // namespace hdmbench
