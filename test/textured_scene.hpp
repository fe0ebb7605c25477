#pragma once

#include "harness/check/verify.hpp"
#include "test/sessions.hpp"

#include <string>
#include <utility>
#include <vector>

namespace hdmbench::test {

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
