#pragma once

#include <span>
#include <string_view>

namespace hdmbench {

/// What the thesis measured in 2008: ATI Radeon X1300 (GPU) against Core 2 Duo E6300, 1.86 GHz (CPU).
struct PublishedTiming {
  std::string_view table; ///< "5.2"
  std::string_view scene; ///< our scene's name
  int size;               ///< N of the N x N image
  double gpu_seconds;
  double cpu_seconds;
  double speed_up; ///< as printed there
};

/// Tables 5.2, 5.4, 5.6 and 5.8: a fixed number of iterations per level, the whole pyramid.
[[nodiscard]] std::span<const PublishedTiming> published_timings();

/// The row for a scene and size; nullptr where the thesis has none.
[[nodiscard]] const PublishedTiming* published_timing(std::string_view scene, int size);

} // namespace hdmbench
