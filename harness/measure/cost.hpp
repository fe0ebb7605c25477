#pragma once

#include "backends/backend.hpp"
#include "harness/scene/scene.hpp"

#include <optional>
#include <vector>

/// What a solution takes at the least, and which share of a device's ceilings that is.
namespace hdmbench {

/// The dense sweeps of one level.
struct LevelWork {
  int sweeps = 0;
  SiteCounts sites{}; ///< by SiteKind
};

/// Returns the work on each level, for schedules whose costs are declared (kernels/data/energy.hpp):
/// candidates, all sites at once, a fixed number of iterations, each level once. Empty for others.
[[nodiscard]] std::vector<LevelWork> level_work(const Scene& scene);

/// What a solution takes at the least.
struct SolutionCost {
  double operations = 0.0;
  double bytes = 0.0; ///< between memory and processor; of levels that a cache holds, too
  /// Those `bytes` that belong to levels which no cache of this machine holds; all of them on a device that
  /// is not a CPU.
  double bytes_from_memory = 0.0;
};

/// What a dense update of a site takes at the least, over the sweeps of a level that pass through the caches
/// together: in a volume every vector has a third component, and moduli are as they were
/// (Backend::bytes_per_update()). None where one of them is not declared.
struct UpdateCost {
  double operations = 0.0;
  double bytes = 0.0;
};
[[nodiscard]] std::optional<UpdateCost> update_cost(const Energy& energy, const Backend& backend,
                                                    SiteKind kind, std::size_t axes, int candidates,
                                                    int sweeps);

/// None where the backend does not declare its bytes or there are no levels. Of `full`, the energy, the
/// number of axes and that of candidates.
[[nodiscard]] std::optional<SolutionCost> solution_cost(const std::vector<LevelWork>& levels,
                                                        const Backend& backend, const Device& device,
                                                        const Level& full);

class Progress;

/// A step of the elastic energy, at all sites of its level, so many times.
struct StepsTaken {
  int times = 0;
  double operations = 0.0; ///< of one
  double bytes = 0.0;
};
/// Returns the steps that a solution takes, the same on every backend: the scene is solved on the CPU to
/// count them. Those without a declared cost (backends/shared/elastic_costs.hpp) count as nothing.
[[nodiscard]] std::vector<StepsTaken> steps_taken(const Scene& scene, Progress& progress);
/// A step's arrays come from memory where no cache holds them.
[[nodiscard]] SolutionCost solution_cost(const std::vector<StepsTaken>& steps, const Backend& backend,
                                         const Device& device);

/// What a level may have and stay in a cache of this machine's processor; 0 on a device that is none.
[[nodiscard]] double cache_bytes(const Backend& backend, const Device& device);

struct CeilingShare {
  double percent = 0.0;           ///< least time that the device would need, over the time that it took
  const char* binding = "memory"; ///< or "arithmetic"
};

/// What binds is what would take longer at the medians of the ceilings. Both at once could be done at their
/// best, so 100 % is a bound, not a forecast.
[[nodiscard]] CeilingShare ceiling_share(const SolutionCost& cost, const Ceilings& ceilings, double seconds);

} // namespace hdmbench
