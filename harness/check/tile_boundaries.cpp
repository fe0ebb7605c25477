#include "harness/check/tile_boundaries.hpp"

#include <random>

namespace hdmbench {

namespace {

/// Up to 20 px: every site's choice depends on what its neighbours weigh.
VectorField rough_start(Extent extent) {
  std::mt19937 source(1);
  VectorField start(extent);
  for (auto* const values : {&start.x, &start.y}) {
    for (float& value : *values) {
      value = 20.0F * (static_cast<float>(source() >> 8) * 0x1p-23F - 1.0F);
    }
  }
  return start;
}

} // namespace

std::vector<Scene> tile_boundary_scenes() {
  std::vector<Scene> scenes;
  for (const Extent extent : {Extent{384, 192}, Extent{383, 191}, Extent{385, 193}}) {
    Scene& scene = scenes.emplace_back(load_scene("square", {.size = extent}));
    scene.name = "square-rough";
    scene.source.clear();
    scene.start = rough_start(extent);
    scene.schedule.start_level = 0;
    scene.schedule.iterations = 5;
  }
  return scenes;
}

} // namespace hdmbench
