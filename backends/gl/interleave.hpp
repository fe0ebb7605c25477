#pragma once

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

} // namespace hdmbench::gl
