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
    std::size_t colour = 0;     ///< of the backend on the device
    bool active = false;        ///< see BenchRow
    std::vector<BenchRow> rows; ///< at most one per size
  };

  std::string scene;
  std::vector<Size> sizes; ///< by the number of pixels; measured ones and those of the thesis
  std::vector<Line> lines;

  [[nodiscard]] static const BenchRow* find(const Line& line, const Size& size);
  /// Backend, method where the scene has several, and whether sites were left out: "openmp, active".
  [[nodiscard]] std::string label_of(const Line& line) const;
  /// The same with the device where the backend has several.
  [[nodiscard]] std::string name_of(const Line& line) const;
};

/// Scenes of the thesis first, in its order. A speed-up is taken back where the verify rows of the same
/// machine, scene, backend and device disagree: `reason` says so. Of rows that differ in threads only the one
/// with the most stays; scaling_figure has the others.
[[nodiscard]] std::vector<SceneTimings> scene_timings(const Results& results, const std::string& machine);

/// "icm" of "icm-active".
[[nodiscard]] std::string dense_method(const std::string& method, bool active);

enum class Quantity { seconds, msites_per_second, bytes_per_site };

/// The quantity of the valid timings, seconds together with the thesis's two lines; empty where no valid
/// timing has it.
[[nodiscard]] std::vector<SizeSeries> size_series(const SceneTimings& timings, Quantity quantity);

/// "Table 5.2"; empty where the thesis did not time the scene.
[[nodiscard]] std::string thesis_table(const std::string& scene);

} // namespace hdmbench::report
