#include "harness/judge/atlas/entry.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/finite_elements.hpp"

#include <algorithm>
#include <random>

namespace hdmbench::atlas {

namespace {

constexpr int size = two_material_side;
constexpr const char* distance = "RMSD to finite elements [px]";
constexpr double limit = 0.25; // pixels
constexpr const char* seen = "before the run: moduli between which cycles stall; after it: the distance that "
                             "the last steps estimate";
constexpr const char* survivor = "--method conjugate-gradients with more --iterations, or --accuracy";

/// A scene that no unique answer belongs to has an empty truth: every method has to refuse it.
Problem against_finite_elements(Scene scene) {
  ReferenceField truth;
  try {
    truth = solve_finite_elements(elastic_problem(scene.full), ElementRule::plane_stress(scene.poisson));
  } catch (const InputError&) {
    truth = {};
  }
  return {.scene = std::move(scene), .truth = std::move(truth)};
}

template <Where is_stiff>
Problem two_materials(double ratio) {
  return against_finite_elements(of_two_materials<is_stiff>(ratio));
}

template <int thickness>
bool in_layer(Extent extent, int x, int y) {
  return x < extent.width / 2 && y % 4 < thickness;
}

bool between_block_and_frame(Extent extent, int x, int y) {
  return !in_inclusion(extent, x, y) && std::min({x, y, extent.width - 1 - x, extent.height - 1 - y}) >= 3;
}

std::vector<Series> elastic_series() {
  return {{.name = "full-multigrid", .method = "full-multigrid"},
          {.name = "conjugate-gradients", .method = "conjugate-gradients"},
          {.name = "30 steps", .method = "conjugate-gradients", .iterations = 30}};
}

/// What all entries have alike.
Entry entry(std::string_view name, std::string_view title, std::string_view mechanism,
            std::string_view knob) {
  return {.name = name,
          .title = title,
          .energy = "elastic",
          .mechanism = mechanism,
          .knob = knob,
          .measure = distance,
          .limit = limit,
          .seen_by = seen,
          .survivor = survivor,
          .warnings = {"not-converged", "no-estimate", "stalling-cycles"},
          .knobs = {},
          .quick_knobs = {},
          .series = elastic_series()};
}

Entry contrast() {
  Entry result = entry("elastic-contrast", "Elastic energy: an inclusion that is ever stiffer",
                       "A coarse function that is half in the stiff inclusion and half outside can move "
                       "neither as it should: cycles alone leave such waves, conjugate gradients take a few "
                       "steps for each.",
                       "ratio of the two moduli");
  result.knobs = {1, 3, 10, 30, 100, 1e3, 1e4};
  result.quick_knobs = {1, 100, 1e4};
  result.problem = two_materials<in_inclusion>;
  return result;
}

Entry poisson() {
  Entry result = entry("elastic-poisson", "Elastic energy: tissue that hardly changes its volume",
                       "Plane stress lets a sheet become thinner, so it does not lock as a volume does when "
                       "Poisson's ratio nears a half; the elements need no cure.",
                       "Poisson's ratio");
  result.knobs = {0, 0.3, 0.4, 0.45, 0.49, 0.499};
  result.quick_knobs = {0, 0.3, 0.499};
  result.problem = [](double knob) {
    Scene scene = shipped("circular", size);
    scene.poisson = knob;
    return against_finite_elements(std::move(scene));
  };
  return result;
}

template <int thickness>
Entry layers() {
  Entry result =
      entry(thickness == 1 ? "elastic-layers" : "elastic-layers-2",
            thickness == 1 ? "Elastic energy: stiff layers one pixel thin"
                           : "Elastic energy: stiff layers two pixels thin",
            "The stiffness of a coarse cell is the mean of its layers, right along them and far too much "
            "across: what a coarse level proposes is then far too small.",
            "ratio of the two moduli");
  result.knobs = {1, 10, 100, 1e3, 1e4};
  result.quick_knobs = {1, 100, 1e4};
  result.problem = two_materials<in_layer<thickness>>;
  return result;
}

Entry supports() {
  Entry result = entry("elastic-supports", "Elastic energy: few supports, and one",
                       "A sheet of two materials, contrast 10, hangs on a few sites: what they say has to "
                       "travel over the whole image. On one it can turn, and is refused.",
                       "sites that are held");
  result.survivor = "two sites and more";
  result.knobs = {64, 16, 8, 4, 3, 2, 1};
  result.quick_knobs = {64, 4, 1};
  result.problem = [](double knob) {
    Scene scene = of_two_materials<in_inclusion>(10.0);
    for (auto* const component : {&scene.full.confidence.x, &scene.full.confidence.y}) {
      std::ranges::fill(*component, 0.0F);
    }
    std::mt19937_64 engine(5);
    for (int i = 0; i < static_cast<int>(knob); ++i) {
      const int x = static_cast<int>(engine() % size);
      const int y = static_cast<int>(engine() % size);
      hold(scene, x, y, static_cast<float>(0.05 * x + 0.03 * y), static_cast<float>(0.02 * x - 0.04 * y));
    }
    return against_finite_elements(std::move(scene));
  };
  return result;
}

Entry free_body() {
  Entry result =
      entry("elastic-free-body", "Elastic energy: a body that nothing but soft tissue holds",
            "A stiff block in the middle is only held by what is around it. How it moves as a whole is "
            "all the slower for cycles to find, the softer that is. Where the modulus around is so small "
            "that it changes no bit when added to the block's, it is void and the block a part that no "
            "condition holds, which is refused.",
            "modulus around the block, relative to it");
  result.survivor = "a condition on the block: x and y at one site, one of them at another";
  result.knobs = {1, 0.1, 0.01, 1e-3, 1e-4, 1e-6, 1e-7, 1e-8};
  result.quick_knobs = {1, 1e-3, 1e-8};
  result.problem = two_materials<between_block_and_frame>;
  return result;
}

} // namespace

std::vector<Entry> elastic_entries() {
  return {contrast(), poisson(), layers<1>(), layers<2>(), supports(), free_body()};
}

} // namespace hdmbench::atlas
