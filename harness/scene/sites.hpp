#pragma once

#include "kernels/data/field.hpp"

#include <vector>

namespace hdmbench {

/// One small integer per pixel: which tissue.
struct LabelField {
  Extent extent;
  std::vector<int> values;
};

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
