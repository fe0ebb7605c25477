#pragma once

#include "kernels/data/pyramid.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace hdmbench {

/// How the sites of all levels of a pyramid lie in the full image and in the level before, as shaders read it
/// (kernels/shaders/resampling.glsl, coarse_levels.comp, sample.frag, project.frag): texels of four floats,
/// whole numbers below 2^24 but for the weight.
struct ResamplingEntries {
  explicit ResamplingEntries(const Pyramid& pyramid);

  /// Per column, then per row, of each level: the two coarse sites around, the weight of the second, the site
  /// sampled of the full image; the first level lies in one of a single site. Then per level: width, height,
  /// sweeps, where its columns begin.
  std::vector<std::array<float, 4>> texels;
  std::vector<std::int32_t> begins; ///< per level where its columns begin; its rows come after them
  std::int32_t levels_begin = 0;    ///< where the entries of the levels themselves begin
};

} // namespace hdmbench
