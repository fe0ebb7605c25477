#include "harness/judge/atlas/families.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench::atlas {

namespace {

constexpr int size = 100; // targets of 16.67 px, which are no sum of candidates

void use_penalty(Scene& scene, double penalty) {
  set_weight(scene, {.penalty = penalty});
}

Problem hard_conditions_with(double penalty) {
  Problem problem = against_fixed_point(shipped("square", size));
  use_penalty(problem.scene, penalty);
  return problem;
}

std::vector<Series> with_fixed_point(std::vector<Series> series) {
  series.insert(series.begin(), {.name = "fixed point", .method = fixed_point_method});
  return series;
}

Entry weak_penalty() {
  return {.name = "penalty-small",
          .title = "Penalty K so small that conditions give way",
          .mechanism = "The observation is an absolute value: it holds a site at its target with at most the "
                       "force K c / 2, and where the tissue pulls harder the site leaves.",
          .knob = "penalty K",
          .measure = "RMSD to the fixed point with hard conditions [px]",
          .limit = 0.5,
          .seen_by = "after the run: observed sites away from their targets",
          .survivor = "K = 1000 (the default)",
          .warnings = {"weak-penalty", "gives-way", "not-met", "still-moving", "stalled"},
          .knobs = {1e3, 100, 30, 10, 3, 1, 0.1, 0.01},
          .quick_knobs = {1e3, 10, 0.1},
          .series = with_fixed_point(usual_series()),
          .problem = hard_conditions_with,
          .error = rmsd_to_truth};
}

Entry strong_penalty() {
  return {
      .name = "penalty-large",
      .title = "Penalty K so large that float32 drowns in it",
      .mechanism = "A candidate's change of energy is the prior's plus K c times the change of a distance; "
                   "at a large K the rounding of that product is more than any prior, so a step is "
                   "decided by rounding.",
      .knob = "penalty K",
      .measure = "RMSD to the fixed point with hard conditions [px]",
      .limit = 0.5,
      .seen_by = "before the run: K times the rounding of a distance against the energy of a step",
      .survivor = "K = 1000 (the default); methods that move to the minimiser itself never form the product",
      .warnings = {"swamping-penalty"},
      .knobs = {1e3, 1e6, 1e9, 1e12, 1e20, 1e30, 1e35, 1e36, 1e37, 1e38},
      .quick_knobs = {1e3, 1e9, 1e38},
      .series = with_fixed_point(usual_series()),
      .problem = hard_conditions_with,
      .error = rmsd_to_truth};
}

Problem shifted(double offset) {
  Problem problem = against_fixed_point(shipped("square", size));
  const auto shift = static_cast<float>(offset);
  VectorField& start = problem.scene.start.emplace(problem.scene.start_field());
  for (auto* const field : {&problem.scene.full.target, &start}) {
    for (float& value : field->x) {
      value += shift;
    }
    for (float& value : field->y) {
      value += shift;
    }
  }
  std::ranges::for_each(problem.truth.x, [&](double& value) { value += offset; });
  std::ranges::for_each(problem.truth.y, [&](double& value) { value += offset; });
  return problem;
}

Entry offset() {
  return {.name = "offset",
          .title = "Displacements far from 0 in float32",
          .mechanism = "The energy knows differences only, but a float near the offset is a multiple of "
                       "offset / 2^23: smaller differences, and at last the steps themselves, are rounded "
                       "away.",
          .knob = "offset added to all targets and the start [px]",
          .measure = "RMSD to the shifted fixed point [px]",
          .limit = 0.25,
          .seen_by = "before the run: the spacing of floats at the largest target against the smallest step",
          .survivor = "subtract a common displacement first and add it afterwards",
          .warnings = {"offset"},
          .knobs = {0, 1e3, 1e4, 1e5, 3e5, 1e6, 3e6, 1e7},
          .quick_knobs = {0, 1e5, 1e7},
          .series = usual_series(),
          .problem = shifted,
          .error = rmsd_to_truth};
}

Entry confidence() {
  return {.name = "confidence",
          .title = "A confidence between 0 and 1",
          .mechanism =
              "The observation is an absolute value: c scales the force that it can hold with, K c / 2, "
              "and is no weight of a mean. Down to a threshold nothing changes, below it the "
              "condition lets go; coarse levels, where a site spans more of the displacement, let "
              "go before the full image does.",
          .knob = "confidence c of the left border",
          .measure = "RMSD to the fixed point [px]",
          .limit = 0.5,
          .seen_by = "after the run: sites far from their own minimum; from 0.001 down nothing tells",
          .survivor = "K c of 300 and more (--penalty)",
          .warnings = {"still-moving", "stalled"},
          .knobs = {1, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3},
          .quick_knobs = {1, 0.03, 0.01},
          .series = usual_series(),
          .problem =
              [](double knob) {
                Scene scene = shipped("square", size);
                for (int y = 0; y < size; ++y) {
                  scene.full.confidence.x[scene.extent().index(0, y)] = static_cast<float>(knob);
                }
                return against_fixed_point(std::move(scene));
              },
          .error = rmsd_to_truth};
}

/// The square scene with dy given only by `count` sites in the middle of the top border, as 0; the start is
/// 10 px everywhere.
Problem few_conditions(double count) {
  Scene scene = shipped("square", 64);
  std::ranges::fill(scene.full.confidence.y, 0.0F);
  std::ranges::fill(scene.full.target.y, 0.0F);
  std::ranges::fill(scene.start.emplace(scene.extent()).y, 10.0F);
  for (int i = 0; i < static_cast<int>(count); ++i) {
    scene.full.confidence.y[scene.extent().index(32 + (i % 2 == 0 ? i / 2 : -1 - i / 2), 0)] = 1.0F;
  }
  return {.scene = std::move(scene)};
}

double mean_dy(const Problem&, const Outcome& outcome) {
  double sum = 0.0;
  for (const float value : outcome.displacement.y) {
    sum += static_cast<double>(value);
  }
  return std::abs(sum) / static_cast<double>(outcome.displacement.y.size());
}

Entry undetermined() {
  return {
      .name = "undetermined",
      .title = "Few conditions, and none",
      .mechanism = "The energy knows differences only: a lone condition must draw the whole image by "
                   "itself, and where nothing prescribes dy every field plus a constant is as good, and "
                   "what comes out is what the start was.",
      .knob = "sites that prescribe dy",
      .measure = "mean dy, which is 0 where the conditions are followed [px]",
      .limit = 0.5,
      .seen_by = "before the run: components that nothing prescribes, conditions that coarse levels lack",
      .survivor = "each component given along a whole side",
      .warnings = {"undetermined", "lost-condition", "out-of-reach", "gives-way", "not-met", "still-moving",
                   "stalled"},
      .knobs = {64, 32, 16, 8, 4, 2, 1, 0},
      .quick_knobs = {64, 4, 0},
      .series = usual_series(),
      .problem = few_conditions,
      .error = mean_dy};
}

} // namespace

std::vector<Entry> condition_entries() {
  return {weak_penalty(), strong_penalty(), offset(), confidence(), undetermined()};
}

} // namespace hdmbench::atlas
