#include "harness/judge/atlas/entry.hpp"
#include "harness/judge/diagnosis/deformation.hpp"
#include "reference/finite_elements.hpp"

#include <algorithm>
#include <cmath>

/// What conditions, materials and the model itself do.
namespace hdmbench::atlas {

namespace {

constexpr int size = 100; // targets of 16.67 px, which are no sum of candidates

Problem hard_conditions_with(double penalty) {
  Problem problem = against_fixed_point(shipped("square", size));
  set_weight(problem.scene, {.penalty = penalty});
  return problem;
}

std::vector<Series> with_fixed_point() {
  std::vector<Series> series = usual_series();
  series.insert(series.begin(), {.name = "fixed point", .method = fixed_point_method});
  return series;
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

double folded_percent(const Problem&, const Outcome& outcome) {
  const std::vector<float> ratios = least_area_ratios(outcome.displacement).values;
  const auto folded = std::ranges::count_if(ratios, [](float ratio) { return !(ratio > 0.0F); });
  return 100.0 * static_cast<double>(folded) / static_cast<double>(ratios.size());
}

std::vector<Series> with_truths() {
  std::vector<Series> series = with_fixed_point();
  series.insert(series.begin(), {.name = "finite elements", .method = finite_elements_method});
  std::erase_if(series, [](const Series& one) { return one.name == "coloured" || one.name == "icm-6"; });
  return series;
}

template <Where is_stiff>
Problem two_materials(double ratio) {
  return against_fixed_point(of_two_materials<is_stiff>(ratio));
}

bool around_inclusion(Extent extent, int x, int y) {
  return !in_inclusion(extent, x, y);
}

bool on_black_field(Extent, int x, int y) {
  return (x + y) % 2 != 0;
}

bool in_thin_layer(Extent extent, int x, int) {
  return x % 2 == 1 && x < extent.width / 2;
}

/// One of the families of two materials: they differ in where the stiff one is.
Entry of_ratio(Entry entry) {
  entry.knob = "ratio of the two moduli";
  entry.warnings = {"contrast", "stiff-boundary", "lost-tissue", "divergence", "stalled", "still-moving"};
  return entry;
}

constexpr std::string_view stiff_sites_follow_late =
    "A stiff site at the interface gives way by 1 / ratio of what its softer neighbour is "
    "ahead, so a candidate of 0.1 px pays only when that is half the ratio times 0.1 px; "
    "from about 100 on both sides move as if they did not know each other, and nothing "
    "changes any more.";

} // namespace

std::vector<Entry> scene_entries() {
  return {
      {.name = "penalty-small",
       .title = "Penalty K so small that conditions give way",
       .mechanism = "The observation is an absolute value: it holds a site at its target with at most the "
                    "force K c / 2, and where the tissue pulls harder the site leaves.",
       .knob = "penalty K",
       .measure = "RMSD to the fixed point with hard conditions [px]",
       .seen_by = "after the run: observed sites away from their targets",
       .survivor = "K = 1000 (the default)",
       .warnings = {"weak-penalty", "gives-way", "not-met", "still-moving", "stalled"},
       .knobs = {1e3, 100, 30, 10, 3, 1, 0.1, 0.01},
       .quick_knobs = {1e3, 10, 0.1},
       .series = with_fixed_point(),
       .problem = hard_conditions_with},
      {.name = "penalty-large",
       .title = "Penalty K so large that float32 drowns in it",
       .mechanism = "A candidate's change of energy is the prior's plus K c times the change of a distance; "
                    "at a large K the rounding of that product is more than any prior, so a step is "
                    "decided by rounding.",
       .knob = "penalty K",
       .measure = "RMSD to the fixed point with hard conditions [px]",
       .seen_by = "before the run: K times the rounding of a distance against the energy of a step",
       .survivor = "K = 1000 (the default); methods that move to the minimiser itself never form the product",
       .warnings = {"swamping-penalty"},
       .knobs = {1e3, 1e6, 1e9, 1e12, 1e20, 1e30, 1e35, 1e36, 1e37, 1e38},
       .quick_knobs = {1e3, 1e9, 1e38},
       .series = with_fixed_point(),
       .problem = hard_conditions_with},
      {.name = "offset",
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
       .problem = shifted},
      {.name = "confidence",
       .title = "A confidence between 0 and 1",
       .mechanism =
           "The observation is an absolute value: c scales the force that it can hold with, K c / 2, "
           "and is no weight of a mean. Down to a threshold nothing changes, below it the "
           "condition lets go; coarse levels, where a site spans more of the displacement, let "
           "go before the full image does.",
       .knob = "confidence c of the left border",
       .seen_by = "after the run: sites far from their own minimum; from 0.001 down nothing tells",
       .survivor = "K c of 300 and more (--penalty)",
       .warnings = {"still-moving", "stalled"},
       .knobs = {1, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3},
       .quick_knobs = {1, 0.03, 0.01},
       .problem =
           [](double knob) {
             Scene scene = shipped("square", size);
             for (int y = 0; y < size; ++y) {
               scene.full.confidence.x[scene.extent().index(0, y)] = static_cast<float>(knob);
             }
             return against_fixed_point(std::move(scene));
           }},
      {.name = "undetermined",
       .title = "Few conditions, and none",
       .mechanism = "The energy knows differences only: a lone condition must draw the whole image by "
                    "itself, and where nothing prescribes dy every field plus a constant is as good, and "
                    "what comes out is what the start was.",
       .knob = "sites that prescribe dy",
       .measure = "mean dy, which is 0 where the conditions are followed [px]",
       .seen_by = "before the run: components that nothing prescribes, conditions that coarse levels lack",
       .survivor = "each component given along a whole side",
       .warnings = {"undetermined", "lost-condition", "out-of-reach", "gives-way", "not-met", "still-moving",
                    "stalled"},
       .knobs = {64, 32, 16, 8, 4, 2, 1, 0},
       .quick_knobs = {64, 4, 0},
       .problem = few_conditions,
       .error = mean_dy},
      of_ratio({.name = "stiff-inclusion",
                .title = "An inclusion that is ever stiffer",
                .mechanism = stiff_sites_follow_late,
                .knob = {},
                .seen_by = "before the run: the largest ratio of neighbouring moduli",
                .survivor = "every method: closed-form stays nearest",
                .knobs = {1, 3, 10, 100, 1e3, 1e4, 1e5, 1e6},
                .quick_knobs = {1, 100, 1e4},
                .problem = two_materials<in_inclusion>}),
      of_ratio({.name = "soft-inclusion",
                .title = "An inclusion that is ever softer",
                .mechanism = stiff_sites_follow_late,
                .knob = {},
                .seen_by = "before the run: the largest ratio of neighbouring moduli",
                .survivor = "--method cascade or closed-form; --steps fine",
                .knobs = {1, 3, 10, 100, 1e3, 1e4, 1e5, 1e6},
                .quick_knobs = {1, 100, 1e4},
                .problem = two_materials<around_inclusion>}),
      of_ratio({.name = "checkerboard",
                .title = "A checkerboard of two materials",
                .mechanism =
                    "A coarse site stands for as much of one material as of the other, and the mean of two "
                    "moduli is not how their mixture moves: what a coarse level adds is wrong by as much as "
                    "the materials differ.",
                .knob = {},
                .seen_by = "before the run: materials that no coarse level resolves",
                .survivor = "--method cascade, closed-form or icm-6, whose fine levels have the last word",
                .knobs = {1, 2, 4, 10, 30, 100, 1e3, 1e4},
                .quick_knobs = {1, 10, 1e3},
                .problem = two_materials<on_black_field>}),
      of_ratio({.name = "layers",
                .title = "Stiff layers one pixel thin",
                .mechanism =
                    "Layers thinner than a coarse site are sampled by chance, as all stiff or all soft, or "
                    "blurred into a mean that is too stiff across the layers.",
                .knob = {},
                .seen_by = "before the run: materials that no coarse level resolves",
                .survivor = "--method closed-form with 500 iterations a level",
                .knobs = {1, 2, 4, 10, 30, 100, 300, 1000},
                .quick_knobs = {1, 10, 1e3},
                .problem = two_materials<in_thin_layer>}),
      {.name = "conflict",
       .title = "Neighbouring conditions that contradict each other",
       .mechanism =
           "Two neighbours that are told to change places fold the tissue between them: from a pixel "
           "on no field does what is asked without folding.",
       .knob = "difference of the targets of two neighbours [px]",
       .measure = "cells folded over [%]",
       .limit = 0.0,
       .seen_by = "before the run: neighbouring targets that differ by more than a pixel",
       .survivor = "none: mend the conditions",
       .warnings = {"conflict"},
       .knobs = {0, 0.5, 0.9, 1.1, 2, 4, 8, 16},
       .quick_knobs = {0, 0.9, 2, 16},
       .series = with_truths(),
       .problem =
           [](double knob) {
             Scene scene = one_material(two_material_side);
             std::ranges::fill(scene.full.target.x, 0.0F);
             std::ranges::fill(scene.full.target.y, 0.0F);
             const auto half = static_cast<float>(knob / 2.0);
             hold(scene, two_material_side / 2 - 1, two_material_side / 2, half, 0.0F);
             hold(scene, two_material_side / 2, two_material_side / 2, -half, 0.0F);
             return Problem{.scene = std::move(scene)};
           },
       .error = folded_percent},
      {.name = "fold-over",
       .title = "Tissue folded over itself",
       .mechanism = "The energy is a sum of squared differences and knows nothing of one pixel passing "
                    "another: where displacements fall by more than a pixel per pixel the image folds, in "
                    "the fixed point and in linear finite elements alike.",
       .knob = "displacement at the skull [% of the image side]",
       .measure = "cells folded over [%]",
       .limit = 0.0,
       .seen_by = "after the run: det(I + grad d) in every cell",
       .survivor = "smaller displacements, or a wider way for them to fade out",
       .warnings = {"fold-over"},
       .knobs = {3, 6, 9, 12, 15, 18, 21, 24, 30},
       .quick_knobs = {3, 15, 30},
       .series = with_truths(),
       .problem =
           [](double knob) {
             Scene scene = shipped("circular-radial", two_material_side);
             const auto factor = static_cast<float>(knob / (100.0 * 20.0 / 300.0));
             std::ranges::for_each(scene.full.target.x, [&](float& value) { value *= factor; });
             std::ranges::for_each(scene.full.target.y, [&](float& value) { value *= factor; });
             return Problem{.scene = std::move(scene)};
           },
       .error = folded_percent,
       .picture = PictureWanted{.series = "icm",
                                .knob = 30.0,
                                .shows = "icm, 30 %: det(I + grad d), blue where folded over",
                                .kind = PictureKind::area_change}},
      {.name = "poisson",
       .title = "Tissue that bulges sideways",
       .mechanism = "The energy keeps x and y apart, so squeezing one way never bulges the other: all of "
                    "Poisson's effect is missing, however well it is minimised.",
       .knob = "Poisson's ratio",
       .measure = "RMSD to finite elements with that ratio [px]",
       .limit = 0.25,
       .seen_by = "by comparison with finite elements only (accuracy)",
       .survivor = "none: a limit of the model",
       .knobs = {0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.49},
       .quick_knobs = {0, 0.3, 0.49},
       .series = {{.name = "fixed point", .method = fixed_point_method},
                  {.name = "closed-form", .method = "closed-form"},
                  {.name = "cascade", .method = "cascade"}},
       .problem = [](double knob) {
         Scene scene = shipped("circular", two_material_side);
         ReferenceField truth =
             solve_finite_elements(elastic_problem(scene.full), ElementRule::plane_stress(knob));
         return Problem{.scene = std::move(scene), .truth = std::move(truth)};
       }}};
}

} // namespace hdmbench::atlas
