#pragma once

#include "kernels/data/field.hpp"

namespace hdmbench {

/// call(x, y) for every site of an image, row by row.
template <typename Call>
void for_each_site(Extent extent, const Call& call) {
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      call(x, y);
    }
  }
}

} // namespace hdmbench
