#pragma once

#include "kernels/data/field.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace hdmbench::gl {

/// Planar arrays of `sites` values as texels of `components` values: texels[components * i + k] =
/// planes[k][i], 0 where a plane is null. Resizes `texels`.
template <std::size_t components>
void interleave(const std::array<const float*, components>& planes, std::size_t sites,
                std::vector<float>& texels) {
  texels.resize(components * sites);
  for (std::size_t i = 0; i < sites; ++i) {
    for (std::size_t k = 0; k < components; ++k) {
      texels[components * i + k] = planes[k] == nullptr ? 0.0F : planes[k][i];
    }
  }
}

/// Two planar fields of `extent` as texels of two sites: first[i], second[i], first[i + 1], second[i + 1]. Of
/// an odd width a row's last texel has zeros for the site beyond. Resizes `texels`.
inline void interleave_pairs(const std::vector<float>& first, const std::vector<float>& second, Extent extent,
                             std::vector<float>& texels) {
  const std::size_t pitch = 4 * static_cast<std::size_t>((extent.width + 1) / 2);
  texels.assign(pitch * static_cast<std::size_t>(extent.height), 0.0F);
  for (int y = 0; y < extent.height; ++y) {
    std::size_t at = static_cast<std::size_t>(y) * pitch;
    for (std::size_t i = extent.index(0, y); i < extent.index(0, y + 1); ++i) {
      texels[at++] = first[i];
      texels[at++] = second[i];
    }
  }
}

} // namespace hdmbench::gl
