#pragma once

#include "kernels/data/field.hpp"

/// What registrations do with pictures, in float on the processor: the same bits whatever the number of
/// threads.
namespace hdmbench {

/// Bilinear interpolation at a finite position in pixels; beyond the border the nearest pixel. The image has
/// at least 2 x 2 pixels. For inner loops: images::linear_at is the same in double.
[[nodiscard]] inline float sample(const std::vector<float>& values, Extent extent, float x, float y) {
  const float inside_x = std::clamp(x, 0.0F, static_cast<float>(extent.width - 1));
  const float inside_y = std::clamp(y, 0.0F, static_cast<float>(extent.height - 1));
  const int left = std::min(static_cast<int>(inside_x), extent.width - 2);
  const int top = std::min(static_cast<int>(inside_y), extent.height - 2);
  const float right = inside_x - static_cast<float>(left);
  const float down = inside_y - static_cast<float>(top);
  const float* const upper = &values[extent.index(left, top)];
  const float* const lower = upper + extent.width;
  const float above = upper[0] + right * (upper[1] - upper[0]);
  const float below = lower[0] + right * (lower[1] - lower[0]);
  return above + down * (below - above);
}

/// With a Gaussian of standard deviation `sigma` pixels, 0: as it is; the border pixels go on beyond it.
[[nodiscard]] ScalarField blurred(const ScalarField& picture, double sigma);

/// Central differences, gray values per pixel; one-sided at the border.
[[nodiscard]] VectorField gradient(const ScalarField& picture);

/// Half as many pixels a side, rounded up: pixel (x, y) is the blurred picture at (2x, 2y).
[[nodiscard]] ScalarField halved(const ScalarField& picture);

/// The mean of the four sites from (2x, 2y) on: for moduli and masks.
[[nodiscard]] ScalarField halved_mean(const ScalarField& field);

/// Where something happened that the labels do not know, a growth or a resection, their moduli say little:
/// where `region` is not 0 each becomes `resistance` times what lies between the region's mean (resistance 0)
/// and itself (1).
void blend_moduli(ScalarField& modulus, const ScalarField& region, float resistance);

/// A displacement (pixels) of an image half the size, in pixels of this one.
[[nodiscard]] VectorField doubled(const VectorField& displacement, Extent extent);

/// `picture` seen from where `displacement` starts: the value at x is picture(x + d(x)).
[[nodiscard]] ScalarField pulled_back(const ScalarField& picture, const VectorField& displacement);

/// Standard deviation of white noise in a picture, gray values: from the median of the absolute second
/// differences across x and y, in which whatever the picture shows counts little.
[[nodiscard]] double noise_of(const ScalarField& picture);

} // namespace hdmbench
