#include "kernels/data/undetermined.hpp"

#include <algorithm>

namespace hdmbench {

Undetermined find_undetermined(int thickness, std::span<const float> confidence) {
  const auto is_free = [](float value) { return !(value > 0.0F); };
  const auto count = static_cast<std::size_t>(std::ranges::count_if(confidence, is_free));
  if (count == 0 || (thickness > 1 && count < confidence.size())) {
    return {};
  }
  return {.sites = count,
          .first = static_cast<std::size_t>(std::ranges::find_if(confidence, is_free) - confidence.begin())};
}

} // namespace hdmbench
