#pragma once

#include "harness/scene/scene.hpp"
#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <vector>

namespace hdmbench {

/// Of an image that samples `full` at about every stride-th pixel of both axes, so that its cells stay
/// squares; first and last sites coincide. stride >= 1.
[[nodiscard]] Extent sampled_extent(Extent full, int stride);

/// Means of the moduli of the pixels around each site of a sampled image, by the share of each pixel in the
/// area that the site stands for. An interface has its place in them to a fraction of a pixel, and a layer
/// thinner than a cell its share.
struct BlockModuli {
  ScalarField mean;         ///< MPa: of layers that are strained side by side
  ScalarField inverse_mean; ///< 1/MPa, of 1 / m: of layers that are loaded one after the other
};

/// Of an image with these moduli, or of a sampled one with these means.
[[nodiscard]] BlockModuli block_moduli(const ScalarField& modulus, const ScalarField& inverse_modulus,
                                       Extent sampled, Alignment alignment);

/// The upper over the lower bound, where it is the largest: 1 where no site stands for more than one modulus.
[[nodiscard]] double largest_mixture(const BlockModuli& blocks);

/// Half and half of moduli a hundred times apart have such a mixture. With more, what a stiff fibre is
/// fastened to decides, and a sampled image cannot know that.
inline constexpr double most_mixed = 25.0;

/// Which modulus between the two bounds a site of a sampled image has.
enum class BlockMean {
  geometric,  ///< of the bounds: the nearest to the truth where tissues meet
  arithmetic, ///< the upper bound: it keeps thin fibres and loses thin cuts
};

/// Conditions of `full` at the sampled sites and its moduli by blocks.
[[nodiscard]] Level sampled_image(const Level& full, const BlockModuli& blocks, BlockMean mean,
                                  Alignment alignment);

/// What the cells of a sampled image cost, pixels: differences between ever finer ones fall like a geometric
/// series, and this is what is left of it. `moved`: the last difference; `moved_before`: the one before it, 0
/// where there was none.
[[nodiscard]] double error_of_cells(double moved, double moved_before);

/// A coarse displacement on the full image.
struct Interpolated {
  VectorField field;                ///< pixels; components with a confidence above 0 are on their targets
  double gap = 0.0;                 ///< pixels: RMS of the way of those components to their targets
  double largest_unknown_gap = 0.0; ///< of those with no observed component at the four coarse sites around
  bool has_springs = false;         ///< such a component has a confidence below 1

  /// An error of the coarse field, pixels, with that of the targets that were imposed on it.
  [[nodiscard]] double error(double of_coarse) const;
};

/// `sampled`: the conditions that the coarse displacement knew.
[[nodiscard]] Interpolated interpolate_to_image(const VectorField& coarse, const Level& sampled,
                                                const Level& full, Alignment alignment);

} // namespace hdmbench
