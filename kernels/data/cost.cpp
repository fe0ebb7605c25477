#include "kernels/data/cost.hpp"

#include <algorithm>

namespace hdmbench {

SiteCounts count_site_kinds(const Level& full, Extent extent, Alignment alignment) {
  const std::vector<int> columns = sampled_indices(extent.width, full.extent.width, alignment);
  const std::vector<int> rows = sampled_indices(extent.height, full.extent.height, alignment);
  // Outside the image is what the centre has, so it is enough to look at the sites that are there.
  const auto is_uniform = [&](int x, int y) {
    const auto modulus = [&](int column, int row) {
      return full.modulus.values[full.extent.index(columns[static_cast<std::size_t>(column)],
                                                   rows[static_cast<std::size_t>(row)])];
    };
    const float centre = modulus(x, y);
    for (int row = std::max(y - 1, 0); row <= std::min(y + 1, extent.height - 1); ++row) {
      for (int column = std::max(x - 1, 0); column <= std::min(x + 1, extent.width - 1); ++column) {
        if (modulus(column, row) != centre) {
          return false;
        }
      }
    }
    return true;
  };
  std::int64_t uniform = 0;
  std::int64_t unobserved = 0;
  std::int64_t both = 0;
#pragma omp parallel for reduction(+ : uniform, unobserved, both)
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t at =
          full.extent.index(columns[static_cast<std::size_t>(x)], rows[static_cast<std::size_t>(y)]);
      const bool is_unobserved = full.confidence.x[at] == 0.0F && full.confidence.y[at] == 0.0F;
      const bool same = is_uniform(x, y);
      uniform += same && !is_unobserved ? 1 : 0;
      unobserved += !same && is_unobserved ? 1 : 0;
      both += same && is_unobserved ? 1 : 0;
    }
  }
  return {static_cast<std::int64_t>(extent.sites()) - uniform - unobserved - both, unobserved, uniform, both};
}

} // namespace hdmbench
