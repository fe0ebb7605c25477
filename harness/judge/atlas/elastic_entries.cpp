#include "harness/judge/atlas/entry.hpp"
#include "harness/judge/truths.hpp"
#include "kernels/data/input_error.hpp"

#include <algorithm>
#include <random>

/// What the elastic energy's methods do.
namespace hdmbench::atlas {

namespace {

/// A scene that no unique answer belongs to has an empty truth: every method has to refuse it.
Problem against_finite_elements(Scene scene) {
  ReferenceField truth;
  try {
    truth = find_finite_elements(scene.full, scene.poisson);
  } catch (const InputError&) {
    truth = {};
  }
  return {.scene = std::move(scene), .truth = std::move(truth)};
}

std::function<Problem(double)> two_materials(Where is_stiff) {
  return [is_stiff](double ratio) { return against_finite_elements(of_two_materials(is_stiff, ratio)); };
}

Problem held_at(double sites) {
  Scene scene = of_two_materials(in_inclusion, 10.0);
  for (auto* const component : {&scene.full.confidence.x, &scene.full.confidence.y}) {
    std::ranges::fill(*component, 0.0F);
  }
  std::mt19937_64 engine(5);
  for (int i = 0; i < static_cast<int>(sites); ++i) {
    const int x = static_cast<int>(engine() % two_material_side);
    const int y = static_cast<int>(engine() % two_material_side);
    hold(scene, x, y, static_cast<float>(0.05 * x + 0.03 * y), static_cast<float>(0.02 * x - 0.04 * y));
  }
  return against_finite_elements(std::move(scene));
}

/// Sets what all entries have alike.
Entry of_elastic(Entry entry) {
  entry.energy = "elastic";
  entry.measure = "RMSD to finite elements [px]";
  entry.limit = 0.25;
  entry.survivor = entry.survivor.empty()
                       ? "--method conjugate-gradients with more --iterations, or --accuracy"
                       : entry.survivor;
  entry.warnings = {"not-converged", "no-estimate", "stalling-cycles"};
  entry.series = {{.name = "full-multigrid", .method = "full-multigrid"},
                  {.name = "conjugate-gradients", .method = "conjugate-gradients"},
                  {.name = "30 steps", .method = "conjugate-gradients", .iterations = 30}};
  return entry;
}

Entry layers(std::string_view name, std::string_view title, int thickness) {
  return of_elastic({.name = name,
                     .title = title,
                     .mechanism = "The mean of its layers is far too stiff across them: what a coarse level "
                                  "proposes is far too small.",
                     .knob = "ratio of the two moduli",
                     .knobs = {1, 10, 100, 1e3, 1e4},
                     .quick_knobs = {1, 100, 1e4},
                     .problem = two_materials([thickness](Extent extent, int x, int y) {
                       return x < extent.width / 2 && y % 4 < thickness;
                     })});
}

} // namespace

std::vector<Entry> elastic_entries() {
  return {
      of_elastic({.name = "elastic-contrast",
                  .title = "Elastic energy: an inclusion that is ever stiffer",
                  .mechanism = "A coarse function half in the stiff inclusion can move neither side as it "
                               "should: cycles alone leave such waves.",
                  .knob = "ratio of the two moduli",
                  .knobs = {1, 3, 10, 30, 100, 1e3, 1e4},
                  .quick_knobs = {1, 100, 1e4},
                  .problem = two_materials(in_inclusion)}),
      of_elastic(
          {.name = "elastic-poisson",
           .title = "Elastic energy: tissue that hardly changes its volume",
           .mechanism = "Plane stress lets a sheet become thinner, so it does not lock as a volume does.",
           .knob = "Poisson's ratio",
           .knobs = {0, 0.3, 0.4, 0.45, 0.49, 0.499},
           .quick_knobs = {0, 0.3, 0.499},
           .problem =
               [](double knob) {
                 Scene scene = shipped("circular", two_material_side);
                 scene.poisson = knob;
                 return against_finite_elements(std::move(scene));
               }}),
      layers("elastic-layers", "Elastic energy: stiff layers one pixel thin", 1),
      layers("elastic-layers-2", "Elastic energy: stiff layers two pixels thin", 2),
      of_elastic({.name = "elastic-supports",
                  .title = "Elastic energy: few supports, and one",
                  .mechanism =
                      "What a few sites say has to travel over the whole image. On one the sheet can "
                      "turn, and is refused.",
                  .knob = "sites that are held",
                  .survivor = "two sites and more",
                  .knobs = {64, 16, 8, 4, 3, 2, 1},
                  .quick_knobs = {64, 4, 1},
                  .problem = held_at}),
      of_elastic({.name = "elastic-free-body",
                  .title = "Elastic energy: a body that nothing but soft tissue holds",
                  .mechanism =
                      "The softer what is around it, the slower cycles find how a stiff block moves as "
                      "a whole; in a void it is refused.",
                  .knob = "modulus around the block, relative to it",
                  .survivor = "a condition on the block: x and y at one site, one of them at another",
                  .knobs = {1, 0.1, 0.01, 1e-3, 1e-4, 1e-6, 1e-7, 1e-8},
                  .quick_knobs = {1, 1e-3, 1e-8},
                  .problem = two_materials([](Extent extent, int x, int y) {
                    return !in_inclusion(extent, x, y) &&
                           std::min({x, y, extent.width - 1 - x, extent.height - 1 - y}) >= 3;
                  })})};
}

} // namespace hdmbench::atlas
