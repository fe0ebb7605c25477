#pragma once

#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

/// Images that sample a scene: their moduli, their conditions, and what their displacement is to the scene.
namespace hdmbench {

/// First and last sites coincide on all sampled images: conditions are on borders.
inline constexpr Alignment sampled_alignment = Alignment::corner;

/// The full image, then those with 4, 8, ... pixels a cell.
[[nodiscard]] std::vector<Extent> sampled_extents(Extent full);

/// Whether a solution of a sampled image is a fair start for finer ones (thesis 9.4): the nearest sampled
/// site has the modulus of nine in ten sites, and observes half of the observed components.
[[nodiscard]] bool is_fair_start(const Level& full, Extent extent);

/// Means of the moduli of the pixels around each site of a sampled image, by the share of each pixel in the
/// area that the site stands for. An interface has its place in them to a fraction of a pixel, and a layer
/// thinner than a cell its share.
struct BlockModuli {
  ScalarField mean;         ///< MPa: of layers that are strained side by side
  ScalarField inverse_mean; ///< 1/MPa, of 1 / m: of layers that are loaded one after the other
};

/// Returns the means of an image with these moduli, or of a sampled one with these means.
[[nodiscard]] BlockModuli block_moduli(const ScalarField& modulus, const ScalarField& inverse_modulus,
                                       Extent sampled);

/// The upper over the lower bound, where it is the largest: 1 where no site stands for more than one modulus.
[[nodiscard]] double largest_mixture(const BlockModuli& blocks);

/// Which modulus between the two bounds a site of a sampled image has.
enum class BlockMean {
  geometric,  ///< of the bounds: the nearest to the truth where tissues meet
  arithmetic, ///< the upper bound: it keeps thin fibres and loses thin cuts
};

/// Conditions of `full` at the sampled sites and its moduli by blocks.
[[nodiscard]] Level sampled_image(const Level& full, const BlockModuli& blocks, BlockMean mean);

/// An observed component that none of the sampled sites around it observes.
struct Unknown {
  std::size_t axis = 0;
  std::size_t site = 0; ///< the nearest one of the sampled image
  float gap = 0.0F;     ///< pixels: its target less what was interpolated
};

/// What became of observed components when they were put on their targets.
struct Imposed {
  double squares = 0.0;  ///< of the gaps, pixels^2
  std::size_t count = 0; ///< components
  std::vector<Unknown> unknown{};
  bool has_springs = false; ///< a confidence is below 1

  void add(const Imposed& other) {
    squares += other.squares;
    count += other.count;
    unknown.insert(unknown.end(), other.unknown.begin(), other.unknown.end());
    has_springs = has_springs || other.has_springs;
  }
};

/// A coarse displacement on the full image.
struct Interpolated {
  VectorField field; ///< pixels; components with a confidence above 0 are on their targets
  Imposed imposed;

  /// RMS of the gaps over sites, pixels.
  [[nodiscard]] double gap() const {
    const std::size_t count = std::max(imposed.count, std::size_t{1});
    return std::sqrt(static_cast<double>(field.extent.axes()) * imposed.squares / static_cast<double>(count));
  }
};

/// `sampled`: the conditions that the coarse displacement knew.
[[nodiscard]] Interpolated interpolate_to_image(const VectorField& coarse, const Level& sampled,
                                                const Level& full);

} // namespace hdmbench
