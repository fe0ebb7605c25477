#include "harness/judge/atlas/entry.hpp"

#include "harness/judge/truths.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/fixed_point.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace hdmbench::atlas {

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all = [] {
    std::vector<Entry> joined;
    for (auto* const group : {schedule_entries, scene_entries, elastic_entries}) {
      std::ranges::move(group(), std::back_inserter(joined));
    }
    return joined;
  }();
  return all;
}

const Entry& find_entry(std::string_view name) {
  const auto found = std::ranges::find(entries(), name, &Entry::name);
  if (found == entries().end()) {
    std::vector<std::string_view> names;
    std::ranges::transform(entries(), std::back_inserter(names), &Entry::name);
    throw InputError(
        fmt::format("the atlas has no entry \"{}\"; its entries are {}", name, fmt::join(names, ", ")));
  }
  return *found;
}

Scene shipped(const char* name, int size) {
  Scene scene = load_scene(name, {.size = Extent{size, size}});
  scale(scene.full.target, static_cast<float>(size) / 300.0F);
  return scene;
}

void scale(VectorField& field, float factor) {
  for (auto* const component : {&field.x, &field.y}) {
    std::ranges::for_each(*component, [&](float& value) { value *= factor; });
  }
}

void set_moduli(Scene& scene, const std::function<float(int x, int y)>& modulus_at) {
  const Extent extent = scene.extent();
  for_each_site(extent,
                [&](int x, int y) { scene.full.modulus.values[extent.index(x, y)] = modulus_at(x, y); });
  set_inverse_modulus(scene.full);
}

Scene of_two_materials(const Where& is_stiff, double ratio) {
  Scene scene = shipped("square", two_material_side);
  set_moduli(scene, [&](int x, int y) {
    return is_stiff(scene.extent(), x, y) ? 10.0F * static_cast<float>(ratio) : 10.0F;
  });
  return scene;
}

Scene one_material(int size) {
  Scene scene = shipped("square", size);
  set_moduli(scene, [](int, int) { return 20.0F; });
  return scene;
}

bool in_inclusion(Extent extent, int x, int y) {
  return std::abs(x - extent.width / 2) <= extent.width / 6 &&
         std::abs(y - extent.height / 2) <= extent.height / 6;
}

void hold(Scene& scene, int x, int y, float dx, float dy) {
  const std::size_t site = scene.extent().index(x, y);
  scene.full.target.x[site] = dx;
  scene.full.target.y[site] = dy;
  scene.full.confidence.x[site] = 1.0F;
  scene.full.confidence.y[site] = 1.0F;
}

Problem against_fixed_point(Scene scene) {
  ReferenceField truth = solve_fixed_point(scene.full).displacement;
  return {.scene = std::move(scene), .truth = std::move(truth)};
}

double rmsd_to_truth(const Problem& problem, const Outcome& outcome) {
  return rmsd(ReferenceField(outcome.displacement), problem.truth);
}

std::vector<Series> usual_series(void (*adjust)(Scene& scene, double knob)) {
  std::vector<Series> series;
  for (const std::string_view method : {"icm", "icm-6", "coloured", "closed-form", "cascade"}) {
    series.push_back({.name = method, .method = method, .adjust = adjust});
  }
  return series;
}

} // namespace hdmbench::atlas
