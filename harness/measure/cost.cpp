#include "harness/measure/cost.hpp"

#include "backends/registry.hpp"
#include "backends/shared/elastic_costs.hpp"
#include "harness/measure/median.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/progress.hpp"
#include "kernels/data/volume_costs.hpp"

#include <algorithm>
#include <memory>
#include <utility>

namespace hdmbench {

std::vector<LevelWork> level_work(const Scene& scene) {
  const Schedule& schedule = scene.schedule;
  if (scene.energy->is_of_cells() || schedule.rule != Rule::steps ||
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

double cache_bytes(const Backend& backend, const Device& device) {
  const bool is_cpu = device.is_software || backend.threads({}) > 0;
  return is_cpu ? static_cast<double>(last_level_cache_bytes()) : 0.0;
}

std::optional<UpdateCost> update_cost(const Energy& energy, const Backend& backend, SiteKind kind,
                                      std::size_t axes, int candidates, int sweeps) {
  const bool in_volume = axes == 3;
  const auto of_image = [&](SiteKind other) { return backend.bytes_per_update(other, sweeps); };
  if (of_image(kind) <= 0.0 || (in_volume && &energy != &thesis_energy)) {
    return std::nullopt;
  }
  const auto i = static_cast<std::size_t>(kind);
  const SiteCost& cost = in_volume ? thesis_costs_in_volumes.at(i) : energy.costs.at(i);
  double bytes = of_image(kind);
  if (in_volume) {
    // What moduli that differ add; nothing where they are read everywhere: a modulus and its inverse.
    const double added = of_image(SiteKind::general) - of_image(SiteKind::uniform);
    const bool differ = kind == SiteKind::general || kind == SiteKind::unobserved;
    const double moduli = added == 0.0 ? 2.0 * sizeof(float) : differ ? added : 0.0;
    bytes = (bytes - moduli) * 1.5 + moduli;
  }
  return UpdateCost{static_cast<double>(cost.operations(candidates)), bytes};
}

std::optional<SolutionCost> solution_cost(const std::vector<LevelWork>& levels, const Backend& backend,
                                          const Device& device, const Level& full) {
  if (levels.empty()) {
    return std::nullopt;
  }
  const double cache = cache_bytes(backend, device);
  SolutionCost cost;
  for (const LevelWork& level : levels) {
    double bytes = 0.0; // of all sweeps
    double state = 0.0; // what one sweep touches
    for (std::size_t i = 0; i < site_kinds; ++i) {
      const auto of = [&](int sweeps) {
        return update_cost(*full.energy, backend, static_cast<SiteKind>(i), full.extent.axes(),
                           full.steps.count(), sweeps);
      };
      const auto sites = static_cast<double>(level.sites[i]);
      const std::optional<UpdateCost> together = of(level.sweeps);
      const std::optional<UpdateCost> alone = of(1);
      if (!together || !alone) {
        return std::nullopt;
      }
      cost.operations += sites * level.sweeps * together->operations;
      bytes += sites * level.sweeps * together->bytes;
      state += sites * alone->bytes;
    }
    cost.bytes += bytes;
    cost.bytes_from_memory += state > cache ? bytes : 0.0;
  }
  return cost;
}

namespace {

/// Takes all steps on another session, and counts them.
class CountingSession final : public ElasticSession {
public:
  CountingSession(std::unique_ptr<ElasticSession> session, std::size_t axes)
      : session_(std::move(session)), axes_(axes) {}

  void take(const MethodStep& step) override {
    add(step_cost(step, axes_), step.level);
    session_->take(step);
  }
  void read(int level, ElasticField field, VectorField& values) const override {
    session_->read(level, field, values);
  }
  bool has_own_laws() const override { return session_->has_own_laws(); }
  std::optional<LeastVolume> law_forces(const LawForces& tissues, const VectorField& displacement,
                                        VectorField& force) override {
    return session_->law_forces(tissues, displacement, force);
  }
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override {
    add(dot_cost(axes_), 0);
    return session_->dot(first, second);
  }
  [[nodiscard]] const std::vector<StepsTaken>& steps() const { return steps_; }

private:
  double do_load_body(const ElasticBody& body) override {
    set_outline(body);
    return session_->load(body);
  }
  void do_load(ElasticHierarchy& hierarchy) override { session_->load(hierarchy); }

  void add(const StepCost& cost, int level) const {
    const auto sites = static_cast<double>(grid(level).sites.sites());
    const StepsTaken one{1, sites * cost.operations, sites * cost.bytes};
    const auto same = std::ranges::find_if(steps_, [&](const StepsTaken& other) {
      return other.operations == one.operations && other.bytes == one.bytes;
    });
    if (same == steps_.end()) {
      steps_.push_back(one);
    } else {
      ++same->times;
    }
  }

  std::unique_ptr<ElasticSession> session_;
  std::size_t axes_;
  mutable std::vector<StepsTaken> steps_;
};

} // namespace

std::vector<StepsTaken> steps_taken(const Scene& scene, Progress& progress) {
  const auto registry = make_backends();
  CountingSession session(find_backend(registry, "openmp").open_elastic({}), scene.extent().axes());
  progress.describe("count the steps of " + scene.name);
  (void)solve_elastic(scene, session, progress, {});
  return session.steps();
}

SolutionCost solution_cost(const std::vector<StepsTaken>& steps, const Backend& backend,
                           const Device& device) {
  const double cache = cache_bytes(backend, device);
  SolutionCost cost;
  for (const StepsTaken& step : steps) {
    cost.operations += step.times * step.operations;
    cost.bytes += step.times * step.bytes;
    cost.bytes_from_memory += step.bytes > cache ? step.times * step.bytes : 0.0;
  }
  return cost;
}

CeilingShare ceiling_share(const SolutionCost& cost, const Ceilings& ceilings, double seconds) {
  const double moving = cost.bytes_from_memory / median(ceilings.copy_bytes_per_second);
  const double calculating = cost.operations / median(ceilings.operations_per_second);
  return {.percent = 100.0 * std::max(moving, calculating) / seconds,
          .binding = moving > calculating ? "memory" : "arithmetic"};
}

} // namespace hdmbench
