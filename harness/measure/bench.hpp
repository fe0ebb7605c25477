#pragma once

#include "backends/backend.hpp"
#include "harness/measure/median.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/solve.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
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

enum class Binding { memory, arithmetic };
inline constexpr std::array<std::string_view, 2> binding_names{"memory", "arithmetic"};
[[nodiscard]] constexpr const auto& names_of(Binding) {
  return binding_names;
}

struct CeilingShare {
  double percent = 0.0; ///< least time that the device would need, over the time that it took
  Binding binding = Binding::memory;
};

/// What binds is what would take longer at the medians of the ceilings. Both at once could be done at their
/// best, so 100 % is a bound, not a forecast.
[[nodiscard]] CeilingShare ceiling_share(const SolutionCost& cost, const Ceilings& ceilings, double seconds);

/// Ceilings of backends, measured when they are asked for first.
class MeasuredCeilings {
public:
  struct Entry {
    std::optional<Ceilings> ceilings;
    std::string reason; ///< why there are none
  };

  [[nodiscard]] const Entry& of(const Backend& backend, const SessionOptions& options);

private:
  std::map<std::pair<std::string, int>, Entry> entries_; ///< by name and threads
};

/// One backend's time for a whole solution.
struct BenchResult {
  std::string backend;
  Device device;
  Work work = Work::dense;
  int threads = 0;                ///< of the CPU, 0 where a driver decides about them
  std::int64_t iterations = 0;    ///< that a solution took, over all levels
  double site_updates = 0.0;      ///< iterations times sites, over all levels, left out or not
  double setup_seconds = 0.0;     ///< opening, compiling, and a first pass of one iteration per level
  std::vector<Timings> samples;   ///< raw, in the order measured
  std::optional<double> speed_up; ///< over the reference's median; only if valid
  /// Over the dense median of the same backend and threads; only where both are valid or neither is checked.
  std::optional<double> speed_up_over_dense;
  std::string reference{};             ///< the backend whose field was compared; empty: none
  bool valid = false;                  ///< the field is the reference's, to the bit
  std::string reason;                  ///< why not valid
  std::optional<SolutionCost> cost{};  ///< of dense work, where it is declared
  std::optional<Ceilings> ceilings{};  ///< of the device, where they were measured
  std::string no_ceilings;             ///< why they were not
  std::optional<CeilingShare> share{}; ///< of cost in the compute seconds
  /// What this process occupied at most while this backend was opened and solved once, the scene and the
  /// driver included.
  std::optional<std::size_t> peak_memory_bytes{};
  /// The same without what the program had before the scene was loaded and without the reference's field.
  std::optional<double> bytes_per_site{};
};

/// median() of one part over the samples: &Timings::total, &Timings::compute.
template <typename Part>
[[nodiscard]] double median_seconds(std::span<const Timings> samples, Part part) {
  std::vector<double> values;
  std::ranges::transform(samples, std::back_inserter(values), part);
  return median(std::move(values));
}

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

/// One way to run a backend.
struct BenchRun {
  const Backend* backend;
  SessionOptions session; ///< work and threads as they are meant
};

/// All that `options` ask for on this scene, the reference's dense run first.
[[nodiscard]] std::vector<BenchRun> bench_runs(const Scene& scene, std::span<const Backend* const> backends,
                                               const BenchOptions& options);

/// Times the scene's schedule on every backend; the first one is the reference for speed and bits. A backend
/// that is not there is returned without samples and with the reason. The scene is as before afterwards; only
/// its schedule is another one while everything is compiled and run for the first time.
[[nodiscard]] std::vector<BenchResult> bench(Scene& scene, std::span<const Backend* const> backends,
                                             const BenchOptions& options, Progress& progress);

/// The result as it stands in a file. Null is what does not apply or was not measured. Of ceilings, and of
/// what is compared with them, giga is 10^9.
[[nodiscard]] nlohmann::json bench_row(const Scene& scene, const BenchResult& result);

/// 10^6 site updates per second of compute; 0 without samples.
[[nodiscard]] double msites_per_second(const BenchResult& result);
/// "icm"; "icm-active" where sites that cannot change were left out.
[[nodiscard]] std::string bench_method_name(const Scene& scene, const BenchResult& result);

} // namespace hdmbench
