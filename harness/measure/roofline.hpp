#pragma once

#include "backends/backend.hpp"
#include "harness/scene/scene.hpp"

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// How near a solution comes to what its device can do at most (roofline model: S. Williams, A. Waterman and
/// D. Patterson, Communications of the ACM 52(4), 2009).
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

} // namespace hdmbench
