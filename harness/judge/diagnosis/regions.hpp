#pragma once

#include "kernels/data/field.hpp"

#include <algorithm>
#include <functional>
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
  std::vector<int> of_site; ///< index into `all`; -1: no part of any
};

/// Whether neighbours in a region may touch at a corner only.
enum class Touching { side, corner };

/// Neighbouring sites a, b belong together where together(a, b), asked of counted sites only.
[[nodiscard]] Regions find_regions(Extent extent, Touching touching,
                                   const std::function<bool(std::size_t)>& counted,
                                   const std::function<bool(std::size_t, std::size_t)>& together);

/// Distance to the nearest counted site (a value > 0) in sites, a diagonal step counting as one; a number
/// larger than any distance in the image where there is none.
[[nodiscard]] std::vector<int> distance_to_nearest(Extent extent, std::span<const float> counted);

} // namespace hdmbench
