#pragma once

#include "kernels/pyramid.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace hdmbench {

/// How the sites of all levels of a pyramid lie in the full image and in the level before, as shaders read it
/// (kernels/resampling.vulkan.glsl, kernels/coarse_levels.glsl): four floats an entry, whole numbers but for
/// the weight.
struct ResamplingEntries {
  explicit ResamplingEntries(const Pyramid& pyramid);

  [[nodiscard]] std::size_t count() const { return planes[0].size(); }

  /// Per column, then per row, of each level: the two coarse sites around, the weight of the second, the site
  /// sampled of the full image. Per level: width, height, sweeps, where its columns begin.
  std::array<std::vector<float>, 4> planes;
  std::vector<std::int32_t> begins; ///< per level where its columns begin; its rows come after them
  std::int32_t levels_begin = 0;    ///< where the entries of the levels themselves begin
};

} // namespace hdmbench
