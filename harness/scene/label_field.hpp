#pragma once

#include "kernels/data/field.hpp"

#include <vector>

namespace hdmbench {

/// One small integer per pixel: which tissue.
struct LabelField {
  Extent extent;
  std::vector<int> values;
};

} // namespace hdmbench
