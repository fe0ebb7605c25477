#include "harness/judge/accuracy/arithmetic.hpp"

#include "harness/check/certificate.hpp"
#include "harness/judge/accuracy/deviation.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/thesis_energy.hpp"
#include "reference/thesis_icm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

namespace hdmbench {

namespace {

/// The candidate that took `before` to `after` in float; none if no candidate does.
std::optional<float> float_step(std::span<const float> candidates, float before, float after) {
  for (const float step : candidates) {
    if (before + step == after) {
      return step;
    }
  }
  return std::nullopt;
}

/// The candidate nearest to what double did.
float double_step(std::span<const float> candidates, double moved) {
  return *std::ranges::min_element(candidates, {},
                                   [&](float step) { return std::abs(static_cast<double>(step) - moved); });
}

/// One iteration of one level: the common start, and where double ended.
struct Iteration {
  const Level& level;
  const VectorField& before;
  const ReferenceField& in_double;
};

class StepJudge {
public:
  StepJudge(const Iteration& iteration, ArithmeticError& error)
      : iteration_(iteration), error_(error), energy_(iteration.level, iteration.before) {}

  void judge(const VectorField& after) {
    const Extent extent = iteration_.level.extent;
    for_each_site(extent, [&](int x, int y) { judge_site(after, x, y); });
    ++error_.iterations;
    error_.steps_compared += 2 * static_cast<std::int64_t>(extent.sites());
  }

private:
  void judge_site(const VectorField& after, int x, int y) {
    const std::size_t i = iteration_.level.extent.index(x, y);
    const double error_x = static_cast<double>(after.x[i]) - iteration_.in_double.x[i];
    const double error_y = static_cast<double>(after.y[i]) - iteration_.in_double.y[i];
    error_.squared_sum += error_x * error_x + error_y * error_y;
    const auto candidates = iteration_.level.steps.values();
    const VectorField& before = iteration_.before;
    const float exact_x = double_step(candidates, iteration_.in_double.x[i] - before.x[i]);
    const float exact_y = double_step(candidates, iteration_.in_double.y[i] - before.y[i]);
    const bool same_x = before.x[i] + exact_x == after.x[i];
    const bool same_y = before.y[i] + exact_y == after.y[i];
    if (same_x && same_y) {
      return;
    }
    const auto found_x = same_x ? exact_x : float_step(candidates, before.x[i], after.x[i]);
    const auto found_y = same_y ? exact_y : float_step(candidates, before.y[i], after.y[i]);
    if (!found_x || !found_y) { // no candidate leads here
      error_.steps_differing += (same_x ? 0 : 1) + (same_y ? 0 : 1);
      error_.beyond_bound += (found_x ? 0 : 1) + (found_y ? 0 : 1);
      return;
    }
    // Whatever was chosen had the smaller float energy, so it cannot be dearer by more than both errors.
    const auto exact = energy_.at(x, y, moved(i, exact_x, exact_y));
    const auto found = energy_.at(x, y, moved(i, *found_x, *found_y));
    const auto exact_bound = energy_change_bound(iteration_.level, before, x, y, exact_x, exact_y);
    const auto found_bound = energy_change_bound(iteration_.level, before, x, y, *found_x, *found_y);
    if (!same_x) {
      count(found.x - exact.x, exact_bound.x + found_bound.x);
    }
    if (!same_y) {
      count(found.y - exact.y, exact_bound.y + found_bound.y);
    }
  }

  [[nodiscard]] ThesisEnergy::Value moved(std::size_t i, float step_x, float step_y) const {
    return {static_cast<double>(iteration_.before.x[i]) + static_cast<double>(step_x),
            static_cast<double>(iteration_.before.y[i]) + static_cast<double>(step_y)};
  }

  void count(double gap, double bound) {
    ++error_.steps_differing;
    const double share = gap / bound;
    error_.largest_gap_over_bound = std::max(error_.largest_gap_over_bound, share);
    if (!(share <= 1.0)) {
      ++error_.beyond_bound;
    }
  }

  const Iteration& iteration_;
  ArithmeticError& error_;
  ThesisEnergy energy_;
};

constexpr int always_compared = 5;

/// In double there is thesis_iteration(), the candidate step all at once, and nothing else.
void require_icm(const Scene& scene) {
  const Schedule& schedule = scene.schedule;
  if (schedule.rule != Rule::steps || scene.full.update != Update::simultaneous || schedule.growth != 0.0) {
    throw InputError(fmt::format("only icm is computed in double beside float32, not {}; leave out --method",
                                 schedule.method));
  }
}

} // namespace

double ArithmeticError::rmsd() const {
  return steps_compared == 0 ? 0.0 : std::sqrt(2.0 * squared_sum / static_cast<double>(steps_compared));
}

ArithmeticError measure_arithmetic(const Scene& scene, const Backend& backend, const SessionOptions& options,
                                   int stride, Progress& progress) {
  require_icm(scene);
  ArithmeticError error;
  const std::unique_ptr<Session> session = backend.open(options);
  LevelSequence levels(scene);
  VectorField before;
  VectorField after;
  for (const int index : levels.order()) {
    const Level& level = levels.sample(index);
    progress.describe(fmt::format("{}: float32 on {} against double, level {} of {}", scene.name,
                                  backend.name(), index, levels.order().size()));
    before = levels.begin(index, after);
    session->load(level);
    session->write(before);
    for (int i = 0; i < scene.schedule.iterations; ++i) {
      session->step(1);
      session->read(after);
      if (i < always_compared || i % stride == 0) {
        const ReferenceField in_double = thesis_iteration(level, ReferenceField(before));
        StepJudge({level, before, in_double}, error).judge(after);
      }
      std::swap(before, after);
      progress.advance(static_cast<double>(level.extent.sites()));
    }
    after = before;
  }
  return error;
}

ReferenceField solve_in_double(const Scene& scene, Progress& progress) {
  require_icm(scene);
  LevelSequence levels(scene);
  const Alignment alignment = scene.schedule.alignment;
  const auto start = [&](Extent extent) { return ReferenceField(scene.start_at(extent)); };
  // As LevelSequence::begin: the start, and what the level before has changed of it.
  const auto begin = [&](const ReferenceField& before, Extent extent) {
    ReferenceField moved = thesis_prolongation(difference(before, start(before.extent)), extent, alignment);
    const ReferenceField own = start(extent);
    std::ranges::transform(own.x, moved.x, moved.x.begin(), std::plus());
    std::ranges::transform(own.y, moved.y, moved.y.begin(), std::plus());
    return moved;
  };
  ReferenceField displacement;
  for (const int index : levels.order()) {
    progress.describe(fmt::format("{}: in double, level {} of {}", scene.name, index, levels.order().size()));
    const Level& level = levels.sample(index);
    displacement = index == levels.order().front() ? start(level.extent) : begin(displacement, level.extent);
    for (int i = 0; i < scene.schedule.iterations; ++i) {
      displacement = thesis_iteration(level, displacement);
      progress.advance(static_cast<double>(level.extent.sites()));
    }
  }
  return displacement;
}

} // namespace hdmbench
