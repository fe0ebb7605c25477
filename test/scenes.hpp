#pragma once

#include "harness/check/verify.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/scene.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/gather.hpp"
#include "test/sessions.hpp"

/// Scenes that several suites take.
namespace hdmbench::test {

/// One material, nothing known, null field, the thesis's schedule on the full resolution alone.
inline Scene plain_scene(Extent extent) {
  Scene scene;
  scene.name = "plain";
  scene.full = plain_level(extent);
  scene.schedule.start_level = 0;
  return scene;
}

/// Gives the x displacement of a column, the same in all rows.
inline void know_column(Scene& scene, int column, float dx) {
  for (int y = 0; y < scene.extent().height; ++y) {
    scene.full.target[0][scene.extent().index(column, y)] = dx;
    scene.full.confidence[0][scene.extent().index(column, y)] = 1.0F;
  }
}

/// plain_scene between a left side that stays and a right side that moves by `dx`; top and bottom keep their
/// y displacement.
inline Scene pulled_scene(Extent extent, float dx) {
  Scene scene = plain_scene(extent);
  know_column(scene, 0, 0.0F);
  know_column(scene, extent.width - 1, dx);
  for (int x = 0; x < extent.width; ++x) {
    scene.full.confidence[1][extent.index(x, 0)] = 1.0F;
    scene.full.confidence[1][extent.index(x, extent.height - 1)] = 1.0F;
  }
  return scene;
}

/// A random problem as a scene; on one level where the texture lies on a grid, which interpolation between
/// levels would leave.
inline Scene textured_scene(const std::string& name, Extent extent, Texture texture, std::uint64_t seed,
                            int iterations) {
  auto problem = random_problem(extent, texture, seed);
  Scene scene;
  scene.name = name;
  scene.full = std::move(problem.level);
  scene.start = std::move(problem.start);
  scene.schedule.iterations = iterations;
  if (texture != Texture::smooth) {
    scene.schedule.start_level = 0;
  }
  return scene;
}

/// Skipped because no tile was ever at rest, so that Work::active had nothing to leave out.
inline bool is_idle(const Comparison& comparison) {
  return comparison.mode == Mode::active && comparison.verdict == Verdict::skipped &&
         comparison.sites_compared > 0 && comparison.sites_at_rest == 0;
}

/// One backend verified against scalar in all modes.
inline std::vector<Comparison> verified(const Scene& scene, const Backend& backend) {
  const Backend* const followers[] = {&backend};
  VerifyOptions options;
  options.session.threads = 1; // the fields are small
  return verify(scene, test::scalar(), followers, options, test::silent());
}

/// One sweep of a level over `from` by update.inc, as the scalar backend has it for everything but
/// Update::sequential.
inline VectorField swept(const Level& level, const VectorField& from, int number) {
  VectorField next(level.extent);
  for_each_site(level.extent, [&](int x, int y) {
    const HdmInFloat::Displacement moved = swept_site<HdmInFloat>(level, from, number, x, y);
    next[0][level.extent.index(x, y)] = moved.x;
    next[1][level.extent.index(x, y)] = moved.y;
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
