#pragma once

#include "harness/scene/file_grid.hpp"
#include "kernels/data/level.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace hdmbench {

/// What is known of the displacement at the pixels of a file.
struct FileConditions {
  VectorField target;     ///< pixels of the scene
  VectorField confidence; ///< as of Level; below 0: a component of which nothing is said
  PixelPositions at{};    ///< among the sites of the scene
  /// Where each pixel lies, in place of `at`, of pixels that are no grid but a row, target and confidence of
  /// as many components as the scene has; they change no site but those around them.
  std::vector<std::array<double, 3>> scattered{};
};

/// What became of the pixels whose displacement is known in some component.
struct CarriedConditions {
  std::size_t given = 0;
  std::size_t acting = 0; ///< not those between sites that others prescribe
  std::size_t exact = 0;  ///< with a component of confidence 1
  double farthest = 0.0;  ///< a target of confidence 1 from what the sites prescribe there, pixels
};

/// Whether every pixel of a file with so many, which lie at `at`, is the site of the same number.
[[nodiscard]] bool are_the_sites(Extent pixels, const PixelPositions& at, Extent sites);

/// Sets target and confidence of `level` at the sites around those pixels, which act where they lie and lose
/// nothing on the way: a component that is certain prescribes all sites that make the field at its pixel, and
/// those between certain pixels; of every other one the sites around share the weight, and take the mean of
/// the weighted targets. What the level had at the pixels that are said something of is replaced. Where the
/// file's pixels are the level's own, all is copied to the bit. `are_springs`: how confidences add up, as
/// stiffnesses of springs (RegisteredEnergy::is_of_cells) or themselves.
CarriedConditions carry_conditions(const FileConditions& conditions, bool are_springs, Level& level);

} // namespace hdmbench
