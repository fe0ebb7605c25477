#include "harness/judge/atlas/families.hpp"
#include "harness/judge/diagnosis/folding.hpp"
#include "reference/finite_elements.hpp"

#include <algorithm>

namespace hdmbench::atlas {

namespace {

constexpr int size = 96;

double folded_percent(const Problem&, const Outcome& outcome) {
  const std::vector<float> ratios = least_area_ratios(outcome.displacement).values;
  const auto folded = std::ranges::count_if(ratios, [](float ratio) { return !(ratio > 0.0F); });
  return 100.0 * static_cast<double>(folded) / static_cast<double>(ratios.size());
}

std::vector<Series> with_truths() {
  std::vector<Series> series = usual_series();
  series.insert(series.begin(), {.name = "fixed point", .method = fixed_point_method});
  series.insert(series.begin(), {.name = "finite elements", .method = finite_elements_method});
  std::erase_if(series, [](const Series& one) { return one.name == "coloured" || one.name == "icm-6"; });
  return series;
}

Entry conflict() {
  return {.name = "conflict",
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
                Scene scene = one_material(size);
                std::ranges::fill(scene.full.target.x, 0.0F);
                std::ranges::fill(scene.full.target.y, 0.0F);
                const auto half = static_cast<float>(knob / 2.0);
                hold(scene, size / 2 - 1, size / 2, half, 0.0F);
                hold(scene, size / 2, size / 2, -half, 0.0F);
                return Problem{.scene = std::move(scene)};
              },
          .error = folded_percent};
}

Entry fold_over() {
  return {.name = "fold-over",
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
                Scene scene = shipped("circular-radial", size);
                const auto factor = static_cast<float>(knob / (100.0 * 20.0 / 300.0));
                std::ranges::for_each(scene.full.target.x, [&](float& value) { value *= factor; });
                std::ranges::for_each(scene.full.target.y, [&](float& value) { value *= factor; });
                return Problem{.scene = std::move(scene)};
              },
          .error = folded_percent,
          .picture = PictureWanted{.series = "icm",
                                   .knob = 30.0,
                                   .shows = "icm, 30 %: det(I + grad d), blue where folded over",
                                   .kind = PictureKind::area_change}};
}

Entry poisson() {
  return {.name = "poisson",
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
          .problem =
              [](double knob) {
                Scene scene = shipped("circular", size);
                ReferenceField truth =
                    solve_finite_elements(elastic_problem(scene.full), ElementRule::plane_stress(knob));
                return Problem{.scene = std::move(scene), .truth = std::move(truth)};
              },
          .error = rmsd_to_truth};
}

} // namespace

std::vector<Entry> model_entries() {
  return {conflict(), fold_over(), poisson()};
}

} // namespace hdmbench::atlas
