#include "harness/judge/atlas/entry.hpp"
#include "harness/judge/diagnosis/deformation.hpp"
#include "harness/judge/truths.hpp"

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
  const auto shift = [&](auto& field) {
    for (auto* const component : {&field.x, &field.y}) {
      for (auto& value : *component) {
        value += static_cast<std::remove_reference_t<decltype(value)>>(offset);
      }
    }
  };
  shift(problem.scene.start.emplace(problem.scene.start_field()));
  shift(problem.scene.full.target);
  shift(problem.truth);
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

std::function<Problem(double)> two_materials(Where is_stiff) {
  return [is_stiff](double ratio) { return against_fixed_point(of_two_materials(is_stiff, ratio)); };
}

/// One of the families of two materials: they differ in where the stiff one is.
Entry of_ratio(Entry entry) {
  entry.knob = "ratio of the two moduli";
  entry.warnings = {"contrast", "stiff-boundary", "lost-tissue", "divergence", "stalled", "still-moving"};
  return entry;
}

constexpr std::string_view stiff_sites_follow_late =
    "A stiff site gives way by 1 / ratio of what its softer neighbour is ahead: from about 100 on no "
    "candidate pays there.";

} // namespace

std::vector<Entry> scene_entries() {
  return {
      {.name = "penalty-small",
       .title = "Penalty K so small that conditions give way",
       .mechanism = "The observation holds a site with at most the force K c / 2; where the tissue pulls "
                    "harder the site leaves.",
       .knob = "penalty K",
       .measure = "RMSD to the fixed point with hard conditions [px]",
       .survivor = "K = 1000 (the default)",
       .warnings = {"weak-penalty", "gives-way", "not-met", "still-moving", "stalled"},
       .knobs = {1e3, 100, 30, 10, 3, 1, 0.1, 0.01},
       .quick_knobs = {1e3, 10, 0.1},
       .series = with_fixed_point(),
       .problem = hard_conditions_with},
      {.name = "penalty-large",
       .title = "Penalty K so large that float32 drowns in it",
       .mechanism = "At a large K the rounding of K c times a distance is more than any prior, so a step is "
                    "decided by rounding.",
       .knob = "penalty K",
       .measure = "RMSD to the fixed point with hard conditions [px]",
       .survivor = "K = 1000 (the default); methods that move to the minimiser itself never form the product",
       .warnings = {"swamping-penalty"},
       .knobs = {1e3, 1e6, 1e9, 1e12, 1e20, 1e30, 1e35, 1e36, 1e37, 1e38},
       .quick_knobs = {1e3, 1e9, 1e38},
       .series = with_fixed_point(),
       .problem = hard_conditions_with},
      {.name = "offset",
       .title = "Displacements far from 0 in float32",
       .mechanism = "A float near the offset is a multiple of offset / 2^23: smaller differences, and at "
                    "last the steps, are rounded away.",
       .knob = "offset added to all targets and the start [px]",
       .measure = "RMSD to the shifted fixed point [px]",
       .limit = 0.25,
       .survivor = "subtract a common displacement first and add it afterwards",
       .warnings = {"offset"},
       .knobs = {0, 1e3, 1e4, 1e5, 3e5, 1e6, 3e6, 1e7},
       .quick_knobs = {0, 1e5, 1e7},
       .problem = shifted},
      {.name = "confidence",
       .title = "A confidence between 0 and 1",
       .mechanism = "c scales the force that an observation can hold with, K c / 2: below a threshold the "
                    "condition lets go, on coarse levels first.",
       .knob = "confidence c of the left border",
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
       .mechanism = "The energy knows differences only: where nothing prescribes dy every field plus a "
                    "constant is as good, and the start comes out.",
       .knob = "sites that prescribe dy",
       .measure = "mean dy, which is 0 where the conditions are followed [px]",
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
                .survivor = "every method: closed-form stays nearest",
                .knobs = {1, 3, 10, 100, 1e3, 1e4, 1e5, 1e6},
                .quick_knobs = {1, 100, 1e4},
                .problem = two_materials(in_inclusion)}),
      of_ratio({.name = "soft-inclusion",
                .title = "An inclusion that is ever softer",
                .mechanism = stiff_sites_follow_late,
                .survivor = "--method cascade or closed-form; --steps fine",
                .knobs = {1, 3, 10, 100, 1e3, 1e4, 1e5, 1e6},
                .quick_knobs = {1, 100, 1e4},
                .problem =
                    two_materials([](Extent extent, int x, int y) { return !in_inclusion(extent, x, y); })}),
      of_ratio({.name = "checkerboard",
                .title = "A checkerboard of two materials",
                .mechanism = "The mean of two moduli is not how their mixture moves: what a coarse level "
                             "adds is wrong by as much as they differ.",
                .survivor = "--method cascade, closed-form or icm-6, whose fine levels have the last word",
                .knobs = {1, 2, 4, 10, 30, 100, 1e3, 1e4},
                .quick_knobs = {1, 10, 1e3},
                .problem = two_materials([](Extent, int x, int y) { return (x + y) % 2 != 0; })}),
      of_ratio({.name = "layers",
                .title = "Stiff layers one pixel thin",
                .mechanism = "Layers thinner than a coarse site are sampled by chance, or blurred into a "
                             "mean that is too stiff across them.",
                .survivor = "--method closed-form with 500 iterations a level",
                .knobs = {1, 2, 4, 10, 30, 100, 300, 1000},
                .quick_knobs = {1, 10, 1e3},
                .problem = two_materials(
                    [](Extent extent, int x, int) { return x % 2 == 1 && x < extent.width / 2; })}),
      {.name = "conflict",
       .title = "Neighbouring conditions that contradict each other",
       .mechanism = "Two neighbours that are told to change places fold the tissue between them.",
       .knob = "difference of the targets of two neighbours [px]",
       .measure = "cells folded over [%]",
       .limit = 0.0,
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
       .mechanism = "Where displacements fall by more than a pixel per pixel the image folds, in linear "
                    "finite elements too.",
       .knob = "displacement at the skull [% of the image side]",
       .measure = "cells folded over [%]",
       .limit = 0.0,
       .survivor = "smaller displacements, or a wider way for them to fade out",
       .warnings = {"fold-over"},
       .knobs = {3, 6, 9, 12, 15, 18, 21, 24, 30},
       .quick_knobs = {3, 15, 30},
       .series = with_truths(),
       .problem =
           [](double knob) {
             Scene scene = shipped("circular-radial", two_material_side);
             const auto factor = static_cast<float>(knob / (100.0 * 20.0 / 300.0));
             scale(scene.full.target, factor);
             return Problem{.scene = std::move(scene)};
           },
       .error = folded_percent,
       .picture = PictureWanted{.series = "icm",
                                .knob = 30.0,
                                .shows = "icm, 30 %: det(I + grad d), blue where folded over",
                                .area_change = true}},
      {.name = "poisson",
       .title = "Tissue that bulges sideways",
       .mechanism = "The energy keeps x and y apart, so squeezing one way never bulges the other.",
       .knob = "Poisson's ratio",
       .measure = "RMSD to finite elements with that ratio [px]",
       .limit = 0.25,
       .survivor = "none: a limit of the model",
       .knobs = {0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.49},
       .quick_knobs = {0, 0.3, 0.49},
       .series = {{.name = "fixed point", .method = fixed_point_method},
                  {.name = "closed-form", .method = "closed-form"},
                  {.name = "cascade", .method = "cascade"}},
       .problem = [](double knob) {
         Scene scene = shipped("circular", two_material_side);
         ReferenceField truth = find_finite_elements(scene.full, knob);
         return Problem{.scene = std::move(scene), .truth = std::move(truth)};
       }}};
}

} // namespace hdmbench::atlas
