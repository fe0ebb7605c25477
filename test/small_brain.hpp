#pragma once

#include "harness/applications/picture.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/scene.hpp"
#include "harness/scene/sites.hpp"

#include <cmath>
#include <cstdint>

/// What tests of registration and detection plant in.
namespace hdmbench::test {

inline constexpr std::uint32_t seed = 5; ///< of texture, planted pairs and noise

/// Soft spots of random place, width and brightness.
inline ScalarField textured(Extent extent) {
  GaussianNoise random(seed);
  ScalarField picture(extent, 60.0F);
  const auto spots = extent.sites() / 60;
  for (std::size_t spot = 0; spot < spots; ++spot) {
    const double centre_x = random.uniform() * extent.width;
    const double centre_y = random.uniform() * extent.height;
    const double width = 2.0 + 4.0 * random.uniform();
    const double brightness = 120.0 * (random.uniform() - 0.5);
    for_each_site(extent, [&](int x, int y) {
      const double squared = std::pow(x - centre_x, 2) + std::pow(y - centre_y, 2);
      picture.values[extent.index(x, y)] +=
          static_cast<float>(brightness * std::exp(-0.5 * squared / (width * width)));
    });
  }
  return picture;
}

/// A brain in small: two tissues in a disc, nothing around.
inline Scene small_brain(int side) {
  Scene scene;
  scene.name = "small";
  const Extent extent{side, side};
  scene.full.extent = extent;
  scene.full.target = VectorField(extent);
  scene.full.confidence = VectorField(extent);
  scene.full.modulus = ScalarField(extent, 10.0F);
  scene.labels = {extent, std::vector<int>(extent.sites())};
  scene.picture = textured(extent);
  const double middle = 0.5 * (side - 1);
  for_each_site(extent, [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    const double radius = std::hypot(x - middle, y - middle) / side;
    const int label = radius > 0.42 ? 0 : radius > 0.2 ? 1 : 2;
    scene.labels.values[site] = label;
    scene.full.modulus.values[site] = label == 2 ? 40.0F : label == 1 ? 20.0F : 10.0F;
    scene.picture.values[site] =
        label == 0 ? 0.0F : scene.picture.values[site] + (label == 2 ? 60.0F : 20.0F);
  });
  set_inverse_modulus(scene.full);
  use_method(scene, usual_method(EnergyModel::elastic));
  return scene;
}

} // namespace hdmbench::test
