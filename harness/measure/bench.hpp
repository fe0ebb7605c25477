#pragma once

#include "backends/backend.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/solve.hpp"

#include <nlohmann/json.hpp>

#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace hdmbench {

/// The dense sweeps of one level.
struct LevelWork {
  int sweeps = 0;
  SiteCounts sites{}; ///< by SiteKind
};

/// By level, for schedules whose costs are declared (kernels/data/energy.hpp): candidates, all sites
/// at once, a fixed number of iterations, each level once. Empty for others.
[[nodiscard]] std::vector<LevelWork> level_work(const Scene& scene);

/// What a solution takes at the least.
struct SolutionCost {
  double operations = 0.0;
  double bytes = 0.0; ///< between memory and processor; of levels that a cache holds, too
  /// Of `bytes` on levels that no cache of this machine holds. All of them on a device that is not a CPU.
  double bytes_from_memory = 0.0;
};

/// None where the backend does not declare its bytes or there are no levels. Of `full`, the energy and the
/// number of candidates.
[[nodiscard]] std::optional<SolutionCost> solution_cost(const std::vector<LevelWork>& levels,
                                                        const Backend& backend, const Device& device,
                                                        const Level& full);

struct CeilingShare {
  double percent = 0.0;           ///< least time that the device would need, over the time that it took
  const char* binding = "memory"; ///< or "arithmetic"
};

/// What binds is what would take longer at the medians of the ceilings. Both at once could be done at their
/// best, so 100 % is a bound, not a forecast.
[[nodiscard]] CeilingShare ceiling_share(const SolutionCost& cost, const Ceilings& ceilings, double seconds);

/// Ceilings of backends by name and threads, as far as they were measured; none where they cannot be.
using MeasuredCeilings = std::map<std::pair<std::string, int>, std::optional<Ceilings>>;

struct BenchOptions {
  SessionOptions session; ///< but for its work
  int repeats = 3;        ///< samples per backend, >= 1
  /// Backends that leave out what rests run a second time so, where the scene's schedule lets them.
  bool dense = true;
  bool active = false;
  bool scaling = false; ///< backends with threads of their own run with 1, 2, 4 ... of them, too
  bool checked = true;  ///< the first backend is the reference; else nothing is checked
  MeasuredCeilings* ceilings = nullptr;  ///< null: not measured
  std::size_t resident_before_scene = 0; ///< resident_bytes() before the scene was loaded
};

/// Times the scene's schedule on every backend; the first one is the reference for speed and bits. Returns
/// the rows of `bench`'s results: null is what does not apply or was not measured, giga is 10^9. A backend
/// that is not there has a row without seconds and with the reason. "peak_memory_bytes" are what this process
/// occupied at most while the backend was opened and solved, the scene and the driver included;
/// "bytes_per_site" leaves out what the program had before the scene was loaded, and the reference's field.
/// The scene is as before afterwards; only its schedule is another one while everything is compiled and run
/// for the first time.
[[nodiscard]] nlohmann::json bench(Scene& scene, std::span<const Backend* const> backends,
                                   const BenchOptions& options, Progress& progress);

} // namespace hdmbench
