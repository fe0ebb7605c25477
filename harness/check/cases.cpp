#include "harness/check/cases.hpp"

#include "harness/scene/method.hpp"
#include "harness/solve/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <random>

namespace hdmbench {

namespace {

/// `square` from a start of up to 20 px, on one level: every site's choice depends on what its neighbours
/// weigh, and what the class of a tile leaves out shows in the first sweep.
Scene square_from_rough_start(Extent extent) {
  Scene scene = load_scene("square", {.size = extent});
  scene.name = "square-rough";
  scene.source.clear();
  std::mt19937 source(1);
  VectorField& start = scene.start.emplace(extent);
  for (std::vector<float>& values : start.planes) {
    for (float& value : values) {
      value = 20.0F * (static_cast<float>(source() >> 8) * 0x1p-23F - 1.0F);
    }
  }
  scene.schedule.start_level = 0;
  scene.schedule.iterations = 5;
  return scene;
}

/// `cube` with a Poisson's ratio at which only the mean of its divergence may count.
Scene selective_cube(Extent extent) {
  Scene scene = load_scene("cube", {.size = extent});
  scene.name = "cube-selective";
  scene.source.clear();
  scene.elastic = {0.45, Integration::selective_reduced};
  return scene;
}

/// `scene` with sides of pixels, or of voxels, that are not the same.
std::function<Scene(Extent)> with_boxes(const std::string& scene) {
  return [scene](Extent extent) {
    Scene boxes = load_scene(scene, {.size = extent});
    boxes.name += "-boxes";
    boxes.source.clear();
    boxes.full.sides = {1.5, 1.0, extent.axes() == 3 ? 2.5 : 1.0};
    boxes.elastic.integration = extent.axes() == 3 ? Integration::selective_reduced : Integration::full;
    use_energy(boxes, energy_near(ReferenceSolution::finite_elements));
    return boxes;
  };
}

/// The names of all methods of the thesis's energy but its own, which the scenes have.
std::vector<std::string> other_methods() {
  std::vector<std::string> names;
  std::ranges::transform(methods().subspan(1), std::back_inserter(names),
                         [](const Method& method) { return std::string(method.name); });
  return names;
}

constexpr Extent small_volume{9, 30, 22};

/// The shipped volumes with sides that are no multiples of anything, by both energies.
std::vector<Case> volume_cases(int iterations, int elastic_iterations) {
  std::vector<Case> cases;
  for (const auto& [scene, size] : {std::pair{"cube", Extent{21, 17, 13}}, {"ball", Extent{18, 21, 15}}}) {
    cases.push_back({.scene = scene, .size = size, .iterations = iterations});
    cases.push_back({.scene = scene,
                     .size = size,
                     .method = std::string(elastic_conjugate_gradients),
                     .iterations = elastic_iterations});
  }
  return cases;
}

} // namespace

std::string Case::name() const {
  std::string text = scene;
  if (size) {
    text += ", " + size->text();
  }
  if (!method.empty()) {
    text += ", " + method;
  }
  return text;
}

bool Case::operator==(const Case& other) const {
  return scene == other.scene && size == other.size && method == other.method;
}

Scene load_case(const Case& one) {
  Scene scene = one.generate ? one.generate(one.size.value()) : load_scene(one.scene, {.size = one.size});
  if (!one.method.empty()) {
    use_method(scene, find_method(one.method));
  }
  limit_iterations(scene, one);
  return scene;
}

Case case_of(const Scene& scene) {
  return {.scene = scene.name, .size = scene.extent(), .method = method_name(scene)};
}

void limit_iterations(Scene& scene, const Case& one) {
  int& iterations = scene.schedule.iterations;
  iterations = std::min(iterations, one.iterations.value_or(iterations));
}

std::span<const Extent> odd_volumes() {
  static constexpr std::array<Extent, 6> all{
      {{2, 2, 2}, {5, 7, 3}, {9, 7, 12}, {33, 7, 15}, {9, 30, 22}, {16, 18, 17}}};
  return all;
}

std::vector<Case> box_cases(int iterations) {
  std::vector<Case> cases;
  for (const auto& [scene, size] : {std::pair{"random", Extent{57, 43}}, {"ball", Extent{14, 17, 11}}}) {
    cases.push_back({.scene = fmt::format("{}-boxes", scene),
                     .size = size,
                     .method = std::string(elastic_conjugate_gradients),
                     .iterations = iterations,
                     .generate = with_boxes(scene)});
  }
  return cases;
}

std::vector<Case> verify_cases(bool quick) {
  std::vector<Case> cases;
  for (const std::string& scene : shipped_scenes()) {
    cases.push_back({.scene = scene});
  }
  // Whole tiles of all backends: the soft square is the tile in the middle of 3 x 3 of the largest, so that
  // around it there is a tile of every backend that sees another modulus at one of its sides or corners
  // alone. And one site less and one more a side.
  for (const Extent extent : {Extent{384, 192}, Extent{383, 191}, Extent{385, 193}}) {
    cases.push_back({.scene = "square-rough", .size = extent, .generate = square_from_rough_start});
  }
  for (const std::string& method : other_methods()) {
    cases.push_back({.scene = "random", .method = method, .iterations = 5});
    cases.push_back({.scene = "random", .size = small_volume, .method = method, .iterations = 2});
  }
  // A shorter run has a modulus at every site, and a region that is prescribed.
  const std::vector<std::string> two{"random", "circular-radial"};
  for (const std::string& scene : quick ? two : shipped_scenes()) {
    cases.push_back({.scene = scene, .method = std::string(elastic_conjugate_gradients), .iterations = 2});
  }
  std::ranges::move(volume_cases(5, 2), std::back_inserter(cases));
  cases.push_back({.scene = "cube-selective",
                   .size = Extent{13, 12, 17},
                   .method = std::string(elastic_conjugate_gradients),
                   .iterations = 2,
                   .generate = selective_cube});
  std::ranges::move(box_cases(2), std::back_inserter(cases));
  return cases;
}

std::vector<Case> golden_cases() {
  constexpr Extent usual{100, 100};
  constexpr Extent odd{257, 130}; // not square, and enough sites for eight threads
  // Iterations: of a scene's own method, and of others.
  constexpr int most = 20;
  constexpr int few = 5;
  std::vector<Case> cases;
  for (const std::string& scene : shipped_scenes()) {
    cases.push_back({.scene = scene, .size = usual, .iterations = most});
  }
  cases.push_back({.scene = "square", .size = odd, .iterations = most});
  for (const std::string& method : other_methods()) {
    cases.push_back({.scene = "random", .size = odd, .method = method, .iterations = few});
  }
  for (const Method& method : energy_near(ReferenceSolution::finite_elements).methods) {
    cases.push_back({.scene = "random", .size = odd, .method = std::string(method.name), .iterations = few});
  }
  for (const char* const scene : {"square", "circular-radial", "brain"}) {
    cases.push_back({.scene = scene,
                     .size = usual,
                     .method = std::string(elastic_conjugate_gradients),
                     .iterations = few});
  }
  for (const std::string& method : other_methods()) {
    cases.push_back({.scene = "random", .size = small_volume, .method = method, .iterations = few});
  }
  std::ranges::move(volume_cases(few, few), std::back_inserter(cases));
  std::ranges::move(box_cases(few), std::back_inserter(cases));
  return cases;
}

} // namespace hdmbench
