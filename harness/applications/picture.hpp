#pragma once

#include "kernels/data/field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string_view>
#include <vector>

/// What registrations do with pictures, in float on the processor: the same bits whatever the number of
/// threads.
namespace hdmbench {

/// The upper one of two in the middle; orders `values`, of which there is one at least.
template <typename Value>
[[nodiscard]] Value median_of(std::vector<Value>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The sum of a * b over sites and components.
[[nodiscard]] double product(const VectorField& a, const VectorField& b);

/// Adds factor * more.
void add(VectorField& field, float factor, const VectorField& more);

/// Linear interpolation at a finite position in pixels; beyond the border the nearest pixel. The picture has
/// at least 2 pixels a side. For inner loops: images::linear_at is the same in double.
[[nodiscard]] inline float sample(const std::vector<float>& values, Extent extent, float x, float y,
                                  float z = 0.0F) {
  const float inside_x = std::clamp(x, 0.0F, static_cast<float>(extent.width - 1));
  const float inside_y = std::clamp(y, 0.0F, static_cast<float>(extent.height - 1));
  const int left = std::min(static_cast<int>(inside_x), extent.width - 2);
  const int top = std::min(static_cast<int>(inside_y), extent.height - 2);
  const float right = inside_x - static_cast<float>(left);
  const float down = inside_y - static_cast<float>(top);
  const auto in_slice = [&](const float* upper) {
    const float* const lower = upper + extent.width;
    const float above = upper[0] + right * (upper[1] - upper[0]);
    const float below = lower[0] + right * (lower[1] - lower[0]);
    return above + down * (below - above);
  };
  if (extent.depth == 1) {
    return in_slice(&values[extent.index(left, top)]);
  }
  const float inside_z = std::clamp(z, 0.0F, static_cast<float>(extent.depth - 1));
  const int before = std::min(static_cast<int>(inside_z), extent.depth - 2);
  const float* const slice = &values[extent.index(left, top, before)];
  const float here = in_slice(slice);
  return here + (inside_z - static_cast<float>(before)) * (in_slice(slice + extent.index(0, 0, 1)) - here);
}

/// With a Gaussian of standard deviation `sigma` pixels, 0: as it is; the border pixels go on beyond it.
[[nodiscard]] ScalarField blurred(const ScalarField& picture, double sigma);
/// The same of every component.
[[nodiscard]] VectorField blurred(const VectorField& field, double sigma);

/// Central differences, gray values per pixel; one-sided at the border.
[[nodiscard]] VectorField gradient(const ScalarField& picture);

/// Returns half as many pixels a side, rounded up.
[[nodiscard]] Extent halved(Extent extent);
/// Half as many pixels a side: pixel (x, y) is the blurred picture at (2x, 2y).
[[nodiscard]] ScalarField halved(const ScalarField& picture);

/// The mean of the four sites, in a volume eight, from (2x, 2y) on: for moduli and masks. Of nothing:
/// nothing.
[[nodiscard]] ScalarField halved_mean(const ScalarField& field);

/// Whether the pictures are looked at there: `unseen` is 0, or empty.
[[nodiscard]] inline bool is_seen(const ScalarField& unseen, std::size_t site) {
  return unseen.values.empty() || unseen.values[site] == 0.0F;
}

/// The mean of the field where `region` is not 0; `otherwise` where it is 0 everywhere, or empty.
[[nodiscard]] double mean_inside(const ScalarField& field, const ScalarField& region, double otherwise);

/// Where something happened that the labels do not know, a growth or a resection, their moduli say little:
/// where `region` is not 0 each becomes `resistance` times what lies between the region's mean (resistance 0)
/// and itself (1).
void blend_moduli(ScalarField& modulus, const ScalarField& region, float resistance);

/// A displacement (pixels) of an image half the size, in pixels of this one.
[[nodiscard]] VectorField doubled(const VectorField& displacement, Extent extent);

/// Where the site at column `x` of a row (Extent::rows) is after the displacement, pixels.
[[nodiscard]] std::array<float, 3> end_of(const VectorField& displacement, int x, int row);

/// `picture` seen from where `displacement` starts: the value at x is picture(x + d(x)).
[[nodiscard]] ScalarField pulled_back(const ScalarField& picture, const VectorField& displacement);

/// Standard deviation of white noise in a picture, gray values: from the median of the absolute second
/// differences across x and y, in which whatever the picture shows counts little.
[[nodiscard]] double noise_of(const ScalarField& picture);

/// `source` with gray values as `target` has them, which shows the same at the same sites: each bin of gray
/// values of the source becomes the mean that the target has there, linear between bins. Two scanners, or
/// one on two days, do not give one tissue one value. Where `unseen` is not 0 the two do not show the same;
/// empty: nowhere.
[[nodiscard]] ScalarField with_values_of(const ScalarField& source, const ScalarField& target,
                                         const ScalarField& unseen);

/// Throws InputError where the two cannot be registered: other sizes, a side below 16 pixels, a value that is
/// not finite, a picture of one gray value.
void require_pair(const ScalarField& source, const ScalarField& target);

/// Makes two pictures ready to be registered: gray values 0 ... 255, both on one scale. Throws InputError as
/// require_pair does, and where nothing bright is at one place in both.
void prepare_pair(ScalarField& source, ScalarField& target);

/// Throws InputError for a region of interest that is nothing, everything or not finite somewhere; `name` is
/// what messages call it.
void require_region(const ScalarField& region, std::string_view name);

/// How alike two pictures are, site by site.
struct Similarity {
  static constexpr int bins = 32; ///< of the gray values of each

  double mean_squares = 0.0;       ///< of the difference, gray values^2
  double correlation = 0.0;        ///< -1 ... 1
  double mutual_information = 0.0; ///< of 32 x 32 bins, bits
};

/// Both have the same extent and more than one gray value, or the last two are 0.
[[nodiscard]] Similarity similarity(const ScalarField& a, const ScalarField& b);

/// Normally distributed numbers of mean 0 and deviation 1, the same on every machine: no library's
/// distribution.
class GaussianNoise {
public:
  explicit GaussianNoise(std::uint32_t seed) : random_(seed) {}

  /// 0 <= number < 1.
  [[nodiscard]] double uniform() { return static_cast<double>(random_()) * 0x1p-32; }
  [[nodiscard]] double operator()() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * M_PI * uniform());
  }

private:
  std::mt19937 random_;
};

} // namespace hdmbench
