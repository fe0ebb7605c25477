#include "harness/judge/atlas/entry.hpp"

#include "harness/judge/truths.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/fixed_point.hpp"

#include <fmt/format.h>

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
    std::string names;
    for (const Entry& entry : entries()) {
      names += fmt::format("{}{}", names.empty() ? "" : ", ", entry.name);
    }
    throw InputError(fmt::format("the atlas has no entry \"{}\"; its entries are {}", name, names));
  }
  return *found;
}

Scene shipped(const char* name, int size) {
  Scene scene = load_scene(name, {.size = Extent{size, size}});
  const float scale = static_cast<float>(size) / 300.0F;
  for (auto* const component : {&scene.full.target.x, &scene.full.target.y}) {
    for (float& target : *component) {
      target *= scale;
    }
  }
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

std::vector<Series> usual_series() {
  return {{.name = "icm", .method = "icm"},
          {.name = "icm-6", .method = "icm-6"},
          {.name = "coloured", .method = "coloured"},
          {.name = "closed-form", .method = "closed-form"},
          {.name = "cascade", .method = "cascade"}};
}

std::vector<Series> usual_series(void (*adjust)(Scene& scene, double knob)) {
  std::vector<Series> series = usual_series();
  for (Series& one : series) {
    one.adjust = adjust;
  }
  return series;
}

} // namespace hdmbench::atlas
