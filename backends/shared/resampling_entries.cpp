#include "backends/shared/resampling_entries.hpp"

#include <cstddef>

namespace hdmbench {

ResamplingEntries::ResamplingEntries(const Pyramid& pyramid) {
  const auto append_axis = [&](int coarse, int fine, int full) {
    const auto around = interpolations(coarse, fine, pyramid.alignment);
    const auto sampled = sampled_indices(fine, full, pyramid.alignment);
    for (std::size_t i = 0; i < around.size(); ++i) {
      texels.push_back({static_cast<float>(around[i].first), static_cast<float>(around[i].second),
                        around[i].weight, static_cast<float>(sampled[i])});
    }
  };
  Extent before{1, 1};
  for (const PyramidLevel& level : pyramid.levels) {
    begins.push_back(static_cast<std::int32_t>(texels.size()));
    append_axis(before.width, level.extent.width, pyramid.full->extent.width);
    append_axis(before.height, level.extent.height, pyramid.full->extent.height);
    before = level.extent;
  }
  levels_begin = static_cast<std::int32_t>(texels.size());
  for (std::size_t i = 0; i < begins.size(); ++i) {
    const PyramidLevel& level = pyramid.levels[i];
    texels.push_back({static_cast<float>(level.extent.width), static_cast<float>(level.extent.height),
                      static_cast<float>(level.sweeps), static_cast<float>(begins[i])});
  }
}

} // namespace hdmbench
