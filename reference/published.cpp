#include "reference/published.hpp"

#include <algorithm>
#include <array>

namespace hdmbench {

namespace {

constexpr std::array<PublishedTiming, 12> timings{{
    {"5.2", "square", 300, 1.27, 67.02, 52.78},
    {"5.2", "square", 600, 4.94, 264.83, 53.61},
    {"5.2", "square", 1200, 20.28, 1056.09, 52.08},
    {"5.4", "square-modified", 300, 9.52, 711.75, 74.76},
    {"5.4", "square-modified", 600, 37.52, 2590.91, 69.05},
    {"5.4", "square-modified", 1200, 151.33, 10329.7, 68.26},
    {"5.6", "circular", 300, 1.63, 91.39, 56.07},
    {"5.6", "circular", 600, 6.42, 363.89, 56.68},
    {"5.6", "circular", 1200, 26.25, 1445.94, 55.08},
    {"5.8", "circular-radial", 300, 1.25, 68.45, 54.76},
    {"5.8", "circular-radial", 600, 4.90, 270.90, 55.29},
    {"5.8", "circular-radial", 1200, 20.24, 1078.13, 53.27},
}};

} // namespace

std::span<const PublishedTiming> published_timings() {
  return timings;
}

const PublishedTiming* published_timing(std::string_view scene, int size) {
  const auto* const found = std::ranges::find_if(
      timings, [&](const PublishedTiming& row) { return row.scene == scene && row.size == size; });
  return found == timings.end() ? nullptr : &*found;
}

} // namespace hdmbench
