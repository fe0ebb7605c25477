#include "harness/measure/roofline.hpp"

#include "harness/measure/median.hpp"
#include "harness/scene/level_sequence.hpp"

#include <algorithm>

namespace hdmbench {

std::vector<LevelWork> level_work(const Scene& scene) {
  const Schedule& schedule = scene.schedule;
  if (scene.energy != EnergyModel::hdm || schedule.rule != Rule::steps ||
      scene.full.update != Update::simultaneous || schedule.stop != Stop::fixed || schedule.mean_modulus) {
    return {};
  }
  const LevelSequence levels(scene);
  std::vector<LevelWork> work;
  for (const int level : levels.order()) {
    work.push_back({.sweeps = levels.iterations(level),
                    .sites = count_site_kinds(scene.full, levels.extent(level), schedule.alignment)});
  }
  return work;
}

std::optional<SolutionCost> solution_cost(const std::vector<LevelWork>& levels, const Backend& backend,
                                          const Device& device, const Level& full) {
  if (levels.empty() || backend.bytes_per_update(SiteKind::general, 1) <= 0.0) {
    return std::nullopt;
  }
  const bool is_cpu = device.is_software || backend.threads({}) > 0;
  const double cache = is_cpu ? static_cast<double>(last_level_cache_bytes()) : 0.0;
  SolutionCost cost;
  for (const LevelWork& level : levels) {
    double bytes = 0.0; // of all sweeps
    double state = 0.0; // what one sweep touches
    for (std::size_t i = 0; i < site_kinds; ++i) {
      const auto kind = static_cast<SiteKind>(i);
      const auto sites = static_cast<double>(level.sites[i]);
      cost.operations += sites * level.sweeps * full.energy->costs[i].operations(full.steps.count());
      bytes += sites * level.sweeps * backend.bytes_per_update(kind, level.sweeps);
      state += sites * backend.bytes_per_update(kind, 1);
    }
    cost.bytes += bytes;
    cost.bytes_from_memory += state > cache ? bytes : 0.0;
  }
  return cost;
}

CeilingShare ceiling_share(const SolutionCost& cost, const Ceilings& ceilings, double seconds) {
  const double moving = cost.bytes_from_memory / median(ceilings.copy_bytes_per_second);
  const double calculating = cost.operations / median(ceilings.operations_per_second);
  return {.percent = 100.0 * std::max(moving, calculating) / seconds,
          .binding = moving > calculating ? Binding::memory : Binding::arithmetic};
}

const MeasuredCeilings::Entry& MeasuredCeilings::of(const Backend& backend, const SessionOptions& options) {
  const auto [found, is_new] =
      entries_.try_emplace({std::string(backend.name()), backend.threads(options)}, Entry{});
  if (is_new) {
    try {
      found->second.ceilings = backend.ceilings(options);
      found->second.reason = found->second.ceilings ? "" : "it has no loops to measure them";
    } catch (const DeviceError& error) {
      found->second.reason = error.what();
    }
  }
  return found->second;
}

} // namespace hdmbench
