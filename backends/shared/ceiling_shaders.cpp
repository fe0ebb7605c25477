#include "backends/shared/ceiling_shaders.hpp"

#include <algorithm>

namespace hdmbench::ceiling_shaders {

std::vector<float> source(std::size_t count) {
  std::vector<float> values(4 * count);
  for (std::size_t i = 0; i < count; ++i) {
    values[4 * i] = static_cast<float>(i % 1000);
    values[4 * i + 1] = static_cast<float>(i % 1000);
    values[4 * i + 2] = -1.0F;
    values[4 * i + 3] = 3.0F;
  }
  return values;
}

void require_copied(std::span<const float> given, std::span<const float> found) {
  if (!std::ranges::equal(given, found)) {
    throw_wrong_result("copy by shader");
  }
}

void require_computed(std::span<const float> given, std::span<const float> found) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    // Chains begin with value + component, + 4 and + 8 of it; after an odd number of rounds each is 3 - that.
    const float begin = given[i / 4 * 4] + static_cast<float>(i % 4);
    if (found[i] != (3.0F - begin) + (3.0F - begin - 4.0F) + (3.0F - begin - 8.0F)) {
      throw_wrong_result("multiply-add shader");
    }
  }
}

} // namespace hdmbench::ceiling_shaders
