#pragma once

#include "kernels/data/field.hpp"

#include <algorithm>
#include <span>
#include <vector>

namespace hdmbench {

/// Sites that are connected.
struct Region {
  int left = 0, right = 0, top = 0, bottom = 0; ///< the sites at its ends
  std::size_t sites = 0;

  [[nodiscard]] int longest_side() const { return std::max(right - left, bottom - top) + 1; }
};

struct Regions {
  std::vector<Region> all;
  std::vector<int> of_site; ///< index into `all`
};

/// Sites of one value that touch at their sides belong together.
[[nodiscard]] Regions find_regions(const ScalarField& field);

/// Distance to the nearest counted site (a value > 0) in sites, a diagonal step counting as one; a number
/// larger than any distance in the image where there is none.
[[nodiscard]] std::vector<int> distance_to_nearest(Extent extent, std::span<const float> counted);

} // namespace hdmbench
