#pragma once

#include "harness/scene/level_sequence.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/gather.hpp"

namespace hdmbench::test {

/// One sweep of a level over `from` by update.inc, as the scalar backend has it for everything but
/// Update::sequential.
inline VectorField swept(const Level& level, const VectorField& from, int number) {
  VectorField next(level.extent);
  for_each_site(level.extent, [&](int x, int y) {
    const HdmInFloat::Displacement moved = swept_site<HdmInFloat>(level, from, number, x, y);
    next.x[level.extent.index(x, y)] = moved.x;
    next.y[level.extent.index(x, y)] = moved.y;
  });
  return next;
}

/// The shipped scenes that are declared exact.
inline std::vector<Scene> exact_scenes() {
  std::vector<Scene> scenes;
  for (const std::string& name : shipped_scenes()) {
    if (name.starts_with("exact")) {
      scenes.push_back(load_scene(name));
    }
  }
  return scenes;
}

/// visit(level, before, number) for every sweep of a scene, coarsest level first; returns the last field. The
/// scene stops after fixed iterations.
template <typename Visit>
VectorField for_each_sweep(const Scene& scene, Visit visit) {
  LevelSequence levels(scene);
  VectorField field;
  for (const int index : levels.order()) {
    const Level& level = levels.sample(index);
    field = levels.begin(index, field);
    const int sweeps = levels.iterations(index) * sweeps_per_iteration(level);
    for (int number = 0; number < sweeps; ++number) {
      visit(level, field, number);
      field = swept(level, field, number);
    }
  }
  return field;
}

} // namespace hdmbench::test
