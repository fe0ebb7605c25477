#pragma once

#include <optional>
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

/// A row of Tables 5.1, 5.3, 5.5, 5.7: 300 x 300, against finite elements (ABAQUS) as ground truth.
struct PublishedAccuracy {
  std::string_view table;            ///< "5.1"
  std::string_view scene;            ///< our scene's name
  std::string_view method;           ///< "CPU" (until stable), "GPU" (fixed iterations), "FEM"
  std::optional<double> mean_energy; ///< the thesis's weighting of the observation is not printed
  std::optional<double> rmsd;        ///< pixels, all sites
  std::optional<int> iterations;     ///< over all levels
  double seconds;
};

[[nodiscard]] std::span<const PublishedAccuracy> published_accuracy();

} // namespace hdmbench
