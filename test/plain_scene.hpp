#pragma once

#include "harness/scene/scene.hpp"

namespace hdmbench::test {

/// One material, nothing known, null field, the thesis's schedule on the full resolution alone.
inline Scene plain_scene(Extent extent) {
  Scene scene;
  scene.name = "plain";
  scene.full = {.extent = extent,
                .target = VectorField(extent),
                .confidence = VectorField(extent),
                .modulus = ScalarField(extent, 1.0F),
                .penalty = 1000.0F};
  set_inverse_modulus(scene.full);
  scene.schedule.start_level = 0;
  return scene;
}

/// Gives the x displacement of a column, the same in all rows.
inline void know_column(Scene& scene, int column, float dx) {
  for (int y = 0; y < scene.extent().height; ++y) {
    scene.full.target.x[scene.extent().index(column, y)] = dx;
    scene.full.confidence.x[scene.extent().index(column, y)] = 1.0F;
  }
}

/// plain_scene between a left side that stays and a right side that moves by `dx`; top and bottom keep their
/// y displacement.
inline Scene pulled_scene(Extent extent, float dx) {
  Scene scene = plain_scene(extent);
  know_column(scene, 0, 0.0F);
  know_column(scene, extent.width - 1, dx);
  for (int x = 0; x < extent.width; ++x) {
    scene.full.confidence.y[extent.index(x, 0)] = 1.0F;
    scene.full.confidence.y[extent.index(x, extent.height - 1)] = 1.0F;
  }
  return scene;
}

} // namespace hdmbench::test
