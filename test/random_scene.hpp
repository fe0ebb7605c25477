#pragma once

#include "harness/scene/scene.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <random>

namespace hdmbench::test {

/// What a random scene may contain.
struct SceneRange {
  int smallest = 40; ///< sites a side
  int largest = 160;
  int inclusions = 5;         ///< at most
  double contrast = 30.0;     ///< of a modulus against that around, either way
  double displacement = 20.0; ///< largest of a target, pixels
};

/// Inclusions in a homogeneous sheet; conditions on some sides, linear along each, and on some discs,
/// constant in each. Every component is given somewhere. The same for the same arguments on every machine.
inline Scene random_scene(std::uint64_t seed, const SceneRange& range = {}) {
  std::mt19937_64 engine(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
  };
  const auto whole = [&](int low, int high) { return static_cast<int>(std::floor(uniform(low, high + 1))); };
  const Extent extent{whole(range.smallest, range.largest), whole(range.smallest, range.largest)};

  Scene scene;
  scene.name = fmt::format("random scene {}", seed);
  scene.source = scene.name;
  scene.full.extent = extent;
  scene.full.modulus = ScalarField(extent, 10.0F);
  scene.full.target = VectorField(extent);
  scene.full.confidence = VectorField(extent);

  const auto for_each_in_disc = [&](double x, double y, double radius_x, double radius_y, auto&& call) {
    for_each_site(extent, [&](int column, int row) {
      const double u = (column - x) / radius_x;
      const double v = (row - y) / radius_y;
      if (u * u + v * v <= 1.0) {
        call(extent.index(column, row));
      }
    });
  };
  for (int i = whole(0, range.inclusions); i > 0; --i) {
    const auto modulus = static_cast<float>(10.0 * std::pow(range.contrast, uniform(-1.0, 1.0)));
    for_each_in_disc(uniform(0, extent.width), uniform(0, extent.height), uniform(1, 0.3 * extent.width),
                     uniform(1, 0.3 * extent.height),
                     [&](std::size_t at) { scene.full.modulus.values[at] = modulus; });
  }
  const auto give = [](std::vector<float>& target, std::vector<float>& confidence, std::size_t at,
                       double value) {
    target[at] = static_cast<float>(value);
    confidence[at] = 1.0F;
  };
  const auto give_side = [&](std::vector<float>& target, std::vector<float>& confidence, int side) {
    const double begin = uniform(-range.displacement, range.displacement);
    const double end = uniform(-range.displacement, range.displacement);
    const bool upright = side < 2;
    const int count = upright ? extent.height : extent.width;
    for (int i = 0; i < count; ++i) {
      const int far = side % 2 == 0 ? 0 : (upright ? extent.width : extent.height) - 1;
      give(target, confidence, upright ? extent.index(far, i) : extent.index(i, far),
           begin + (end - begin) * i / count);
    }
  };
  for (auto [target, confidence] : {std::pair{&scene.full.target.x, &scene.full.confidence.x},
                                    std::pair{&scene.full.target.y, &scene.full.confidence.y}}) {
    give_side(*target, *confidence, whole(0, 3));
    for (int side = 0; side < 4; ++side) {
      if (uniform(0, 1) < 0.4) {
        give_side(*target, *confidence, side);
      }
    }
  }
  for (int i = whole(0, 3); i > 0; --i) {
    const double x = uniform(-range.displacement, range.displacement) / 4.0;
    const double y = uniform(-range.displacement, range.displacement) / 4.0;
    for_each_in_disc(uniform(0, extent.width), uniform(0, extent.height), uniform(1, 0.1 * extent.width),
                     uniform(1, 0.1 * extent.height), [&](std::size_t at) {
                       give(scene.full.target.x, scene.full.confidence.x, at, x);
                       give(scene.full.target.y, scene.full.confidence.y, at, y);
                     });
  }
  set_inverse_modulus(scene.full);
  set_weight(scene, {.penalty = 1e4});
  return scene;
}

} // namespace hdmbench::test
