#pragma once

#include "harness/report/plots.hpp"
#include "harness/report/results.hpp"

#include <string>
#include <vector>

namespace hdmbench::report {

/// What one machine measured on one scene, ordered for tables and plots.
struct SceneTimings {
  struct Size {
    std::int64_t width = 0;
    std::int64_t height = 0;

    bool operator==(const Size&) const = default;
  };
  /// One backend on one device by one method.
  struct Line {
    std::string backend;
    std::string device;
    std::string method;
    std::size_t colour = 0;
    std::vector<BenchRow> rows; ///< at most one per size
  };

  std::string scene;
  std::vector<Size> sizes; ///< by the number of pixels; measured ones and those of the thesis
  std::vector<Line> lines;

  [[nodiscard]] static const BenchRow* find(const Line& line, const Size& size);
  /// The line's name where several lines may share a backend: "openmp, icm-active".
  [[nodiscard]] std::string name_of(const Line& line) const;
};

/// Scenes of the thesis first, in its order. A speed-up is taken back where the verify rows of the same
/// machine, scene, backend and device disagree: `reason` says so.
[[nodiscard]] std::vector<SceneTimings> scene_timings(const Results& results, const std::string& machine);

/// Valid timings together with the thesis's two lines; empty where there is no valid timing.
[[nodiscard]] std::vector<TimeSeries> time_series(const SceneTimings& timings);

/// "Table 5.2"; empty where the thesis did not time the scene.
[[nodiscard]] std::string thesis_table(const std::string& scene);

} // namespace hdmbench::report
