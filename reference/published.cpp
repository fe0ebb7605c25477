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

constexpr std::array<PublishedAccuracy, 12> accuracies{{
    {"5.1", "square", "CPU", 0.15469, 1.54026, 336, 3.94},
    {"5.1", "square", "GPU", 0.00350, 1.72135, 500, 1.27},
    {"5.1", "square", "FEM", std::nullopt, std::nullopt, std::nullopt, 1.30},
    {"5.3", "square-modified", "CPU", 0.00356, 0.59, 468, 5.453},
    {"5.3", "square-modified", "GPU", 0.00359, 0.46, 3000, 9.516},
    {"5.3", "square-modified", "FEM", std::nullopt, std::nullopt, std::nullopt, 1.30},
    {"5.5", "circular", "CPU", 0.12984, 1.43, 686, 23.67},
    {"5.5", "circular", "GPU", 0.19404, 1.44, 700, 1.63},
    {"5.5", "circular", "FEM", std::nullopt, std::nullopt, std::nullopt, 1.30},
    {"5.7", "circular-radial", "CPU", 31.7299, 0.60, 558, 39.34},
    {"5.7", "circular-radial", "GPU", 32.4421, 0.60, 500, 1.25},
    {"5.7", "circular-radial", "FEM", std::nullopt, std::nullopt, std::nullopt, 0.70},
}};

} // namespace

std::span<const PublishedAccuracy> published_accuracy() {
  return accuracies;
}

std::span<const PublishedTiming> published_timings() {
  return timings;
}

const PublishedTiming* published_timing(std::string_view scene, int size) {
  const auto* const found = std::ranges::find_if(
      timings, [&](const PublishedTiming& row) { return row.scene == scene && row.size == size; });
  return found == timings.end() ? nullptr : &*found;
}

} // namespace hdmbench
