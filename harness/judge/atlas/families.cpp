#include "harness/judge/atlas/families.hpp"

#include "harness/judge/accuracy/deviation.hpp"
#include "reference/fixed_point.hpp"

#include <cmath>

namespace hdmbench::atlas {

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
  return {{.name = "icm", .method = "icm"},           {.name = "icm-6", .method = "icm-6"},
          {.name = "coloured", .method = "coloured"}, {.name = "closed-form", .method = "closed-form"},
          {.name = "cascade", .method = "cascade"}};
}

} // namespace hdmbench::atlas
