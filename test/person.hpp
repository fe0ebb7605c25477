#pragma once

#include "harness/applications/picture.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/scene.hpp"
#include "harness/scene/sites.hpp"
#include "test/random_level.hpp"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <utility>

/// Pictures of people for registration and detection.
namespace hdmbench::test {

inline constexpr std::uint32_t picture_seed = 5; ///< of texture, planted pairs and noise

/// Soft spots of random place, width and brightness.
inline ScalarField textured(Extent extent) {
  GaussianNoise random(picture_seed);
  ScalarField picture(extent, 60.0F);
  const bool in_volume = extent.depth > 1;
  const auto spots = extent.sites() / (in_volume ? 600 : 60);
  for (std::size_t spot = 0; spot < spots; ++spot) {
    const double centre_x = random.uniform() * extent.width;
    const double centre_y = random.uniform() * extent.height;
    const double centre_z = in_volume ? random.uniform() * extent.depth : 0.0;
    const double width = 2.0 + 4.0 * random.uniform();
    const double brightness = 120.0 * (random.uniform() - 0.5);
    for_each_site(extent, [&](int x, int y, int z) {
      const double squared =
          std::pow(x - centre_x, 2) + std::pow(y - centre_y, 2) + std::pow(z - centre_z, 2);
      picture.values[extent.index(x, y, z)] +=
          static_cast<float>(brightness * std::exp(-0.5 * squared / (width * width)));
    });
  }
  return picture;
}

/// A brain in small: two tissues in a disc, in a volume of so many slices in an ellipsoid; nothing around.
inline Scene small_brain(int side, int slices = 1) {
  Scene scene;
  scene.name = "small";
  const Extent extent{side, side, slices};
  scene.full = plain_level(extent, 10.0F, Level{}.penalty);
  scene.labels = {extent, std::vector<int>(extent.sites())};
  scene.picture = textured(extent);
  const double middle = 0.5 * (side - 1);
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t site = extent.index(x, y, z);
    const double above = (z - 0.5 * (slices - 1)) * side / slices;
    const double radius = std::hypot(std::hypot(x - middle, y - middle), above) / side;
    const int label = radius > 0.42 ? 0 : radius > 0.2 ? 1 : 2;
    scene.labels.values[site] = label;
    scene.full.modulus.values[site] = label == 2 ? 40.0F : label == 1 ? 20.0F : 10.0F;
    scene.picture.values[site] =
        label == 0 ? 0.0F : scene.picture.values[site] + (label == 2 ? 60.0F : 20.0F);
  });
  set_inverse_modulus(scene.full);
  use_energy(scene, find_energy("elastic"));
  return scene;
}

/// A disc of tissue of `side` pixels in a folder, before and after: source.nrrd, target.nrrd (moved by 1.5
/// and -0.5 pixels, with that standard deviation of noise), region.nrrd, labels.nrrd, positions.nrrd,
/// person.toml.
inline void write_person(const std::filesystem::path& folder, int side, const Placement& placement = {},
                         double noise = 0.0) {
  const Extent extent{side, side};
  ScalarField source(extent);
  ScalarField target(extent);
  ScalarField region(extent);
  VectorField positions(extent);
  LabelField labels{extent, std::vector<int>(extent.sites())};
  GaussianNoise random(1);
  const double middle = 0.5 * side;
  const auto gray = [&](double x, double y) {
    const double radius = std::hypot(x - middle, y - middle);
    return (120.0 + 60.0 * std::sin(0.6 * x) * std::cos(0.5 * y)) /
           (1.0 + std::exp(2.0 * (radius - 0.375 * side)));
  };
  for_each_site(extent, [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    source.values[site] = static_cast<float>(gray(x, y));
    target.values[site] = static_cast<float>(gray(x - 1.5, y + 0.5) + noise * random());
    labels.values[site] = std::hypot(x - middle, y - middle) < 0.39 * side ? 1 : 0;
    region.values[site] = std::hypot(x - 0.53125 * side, y - 0.46875 * side) < 0.125 * side ? 1.0F : 0.0F;
    positions[0][site] = static_cast<float>(x) + 0.5F;
    positions[1][site] = static_cast<float>(y);
  });
  write_scalar(folder / "source.nrrd", source, 1.0, placement);
  write_scalar(folder / "target.nrrd", target, 1.0, placement);
  write_scalar(folder / "region.nrrd", region, 1.0, placement);
  write_vector(folder / "positions.nrrd", positions, 1.0);
  write_labels(folder / "labels.nrrd", labels, 1.0, placement);
  std::ofstream(folder / "person.toml") << R"([image]
labels = "labels.nrrd"
picture = "source.nrrd"
[[tissue]]
label = 0
name = "outside"
modulus = 10.0
[[tissue]]
label = 1
name = "tissue"
modulus = 20.0
)";
}

} // namespace hdmbench::test
