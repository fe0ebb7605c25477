#include "harness/judge/arithmetic.hpp"

#include "harness/check/certificate.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/thesis_energy.hpp"
#include "reference/thesis_icm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace hdmbench {

namespace {

/// Compares every step of an iteration that took `before` to `after` with that of `in_double`.
class StepJudge {
public:
  StepJudge(const Level& level, const VectorField& before, const ReferenceField& in_double,
            ArithmeticError& error)
      : level_(level), before_(before), in_double_(in_double), error_(error), energy_(level, before) {}

  void judge(const VectorField& after) {
    for_each_site(level_.extent, [&](int x, int y) { judge_site(after, x, y); });
    error_.steps_compared += 2 * static_cast<std::int64_t>(level_.extent.sites());
  }

private:
  /// One component: the candidate nearest to what double did, and that which float took; none if none did.
  struct Steps {
    float exact;
    std::optional<float> found;
    bool same;
  };

  [[nodiscard]] Steps steps(float before, float after, double in_double) const {
    const auto candidates = level_.steps.values();
    const double moved = in_double - static_cast<double>(before);
    const float exact = *std::ranges::min_element(
        candidates, {}, [&](float step) { return std::abs(static_cast<double>(step) - moved); });
    if (before + exact == after) {
      return {exact, exact, true};
    }
    const auto found = std::ranges::find(candidates, after, [&](float step) { return before + step; });
    return {exact, found == candidates.end() ? std::nullopt : std::optional(*found), false};
  }

  void judge_site(const VectorField& after, int x, int y) {
    const std::size_t i = level_.extent.index(x, y);
    const Steps in_x = steps(before_[0][i], after[0][i], in_double_[0][i]);
    const Steps in_y = steps(before_[1][i], after[1][i], in_double_[1][i]);
    if (in_x.same && in_y.same) {
      return;
    }
    error_.steps_differing += (in_x.same ? 0 : 1) + (in_y.same ? 0 : 1);
    if (!in_x.found || !in_y.found) { // no candidate leads here
      error_.beyond_bound += (in_x.found ? 0 : 1) + (in_y.found ? 0 : 1);
      return;
    }
    // Whatever was chosen had the smaller float energy, so it cannot be dearer by more than both errors.
    const auto moved = [&](float step_x, float step_y) -> ThesisEnergy::Value {
      return {static_cast<double>(before_[0][i]) + static_cast<double>(step_x),
              static_cast<double>(before_[1][i]) + static_cast<double>(step_y)};
    };
    const auto exact = energy_.at(x, y, moved(in_x.exact, in_y.exact));
    const auto found = energy_.at(x, y, moved(*in_x.found, *in_y.found));
    const auto exact_bound =
        proofs_of(level_).energy_change_bound(level_, before_, x, y, in_x.exact, in_y.exact);
    const auto found_bound =
        proofs_of(level_).energy_change_bound(level_, before_, x, y, *in_x.found, *in_y.found);
    if (!in_x.same) {
      count(found.x - exact.x, exact_bound.x + found_bound.x);
    }
    if (!in_y.same) {
      count(found.y - exact.y, exact_bound.y + found_bound.y);
    }
  }

  void count(double gap, double bound) {
    const double share = gap / bound;
    error_.largest_gap_over_bound = std::max(error_.largest_gap_over_bound, share);
    error_.beyond_bound += share <= 1.0 ? 0 : 1;
  }

  const Level& level_;
  const VectorField& before_;
  const ReferenceField& in_double_;
  ArithmeticError& error_;
  ThesisEnergy energy_;
};

} // namespace

ArithmeticError measure_arithmetic(const Scene& scene, const Backend& backend, const SessionOptions& options,
                                   int stride, Progress& progress) {
  constexpr int always_compared = 5;
  if (scene.schedule.rule != Rule::steps || scene.full.update != Update::simultaneous ||
      scene.schedule.growth != 0.0) {
    throw InputError(fmt::format("only icm is computed in double beside float32, not {}; leave out --method",
                                 scene.schedule.method));
  }
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
        StepJudge(level, before, in_double, error).judge(after);
      }
      std::swap(before, after);
      progress.advance(static_cast<double>(level.extent.sites()));
    }
    after = before;
  }
  return error;
}

} // namespace hdmbench
