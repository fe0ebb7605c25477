#pragma once

#include "harness/check/verify.hpp"
#include "harness/scene/scene.hpp"
#include "harness/scene/sites.hpp"
#include "harness/scene/walls.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "test/sessions.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

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

/// Gives the x displacement of a column, the same in all rows of all slices.
inline void know_column(Scene& scene, int column, float dx) {
  for (int row = 0; row < scene.extent().rows(); ++row) {
    scene.full.target[0][scene.extent().index(column, row)] = dx;
    scene.full.confidence[0][scene.extent().index(column, row)] = 1.0F;
  }
}

/// plain_scene between a left side that stays and a right side that moves by `dx`; top and bottom keep their
/// y displacement, of a volume front and back their z displacement.
inline Scene pulled_scene(Extent extent, float dx) {
  Scene scene = plain_scene(extent);
  know_column(scene, 0, 0.0F);
  know_column(scene, extent.width - 1, dx);
  for_each_site(extent, [&](int x, int y, int z) {
    const std::array at{x, y, z};
    for (std::size_t axis = 1; axis < extent.axes(); ++axis) {
      if (at[axis] == 0 || at[axis] == extent.sides()[axis] - 1) {
        scene.full.confidence[axis][extent.index(x, y, z)] = 1.0F;
      }
    }
  });
  return scene;
}

/// A body of the image's sites within a shape, which is told ways from the middle, shortest sides of a pixel;
/// on its outline it slides.
inline Level body_in_a_wall(Extent extent, const std::function<bool(const std::array<double, 3>&)>& is_body,
                            const std::array<double, 3>& step = {1.0, 1.0, 1.0}) {
  Level level = plain_level(extent, 1.0F);
  level.sides = step;
  std::vector<bool> beyond(extent.sites());
  for_each_site(extent, [&](int x, int y, int z) {
    beyond[extent.index(x, y, z)] =
        !is_body({step[0] * (x - 0.5 * (extent.width - 1)), step[1] * (y - 0.5 * (extent.height - 1)),
                  step[2] * (z - 0.5 * (extent.depth - 1))});
  });
  set_wall(beyond, beyond, step, level);
  std::ranges::replace(level.modulus.values, 0.0F, 0.5F * void_share);
  return level;
}

/// One byte for each site: 1 where it is not void.
inline std::vector<std::uint8_t> sites_of_tissue(const Level& level) {
  std::vector<std::uint8_t> sites(level.extent.sites());
  std::ranges::transform(level.modulus.values, sites.begin(),
                         [least = void_modulus(level)](float modulus) { return modulus >= least ? 1 : 0; });
  return sites;
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

} // namespace hdmbench::test
