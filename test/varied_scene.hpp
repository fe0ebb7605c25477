#pragma once

#include "harness/scene/scene.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

namespace hdmbench::test {

/// Which shapes a scene's tissues have.
enum class Make { blobs, cells, layers, noise };

/// A scene that no setting was tuned on. Tissues as blobs, Voronoi cells, wavy layers or noise, of 2 to 6
/// moduli that spread over `contrast` (2 ... 1000); smooth conditions on one to four sides; every second one
/// has observations scattered over 2 % of its sites as well, smooth in themselves, that the tissue need not
/// agree with. Sides of fewest_pixels ... most_pixels. The same for the same seed on every machine.
struct VariedScene {
  Make make = Make::blobs;
  double contrast = 1.0;
  bool scattered = false;
  Scene scene;
};

inline VariedScene varied_scene(std::uint64_t seed, double most_contrast = 1000.0, int fewest_pixels = 32,
                                int most_pixels = 72) {
  std::mt19937_64 engine(7919 * seed + 13);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
  };
  const auto whole = [&](int low, int high) { return static_cast<int>(std::floor(uniform(low, high + 1))); };

  VariedScene varied;
  varied.make = static_cast<Make>(seed % 4);
  varied.scattered = seed / 4 % 2 == 1;
  varied.contrast = std::pow(10.0, uniform(std::log10(2.0), std::log10(most_contrast)));
  const Extent extent{whole(fewest_pixels, most_pixels), whole(fewest_pixels, most_pixels)};
  Scene& scene = varied.scene;
  scene.name = fmt::format("varied_scene({})", seed);
  scene.source = scene.name;
  scene.poisson = std::array{0.0, 0.3, 0.45}[seed % 3];
  scene.full.extent = extent;
  scene.full.modulus = ScalarField(extent, 10.0F);
  scene.full.target = VectorField(extent);
  scene.full.confidence = VectorField(extent);

  std::vector<float> moduli(static_cast<std::size_t>(whole(2, 6)));
  for (std::size_t i = 0; i < moduli.size(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(moduli.size() - 1);
    moduli[i] = static_cast<float>(std::pow(varied.contrast, share));
  }
  const auto any_modulus = [&] {
    return moduli[static_cast<std::size_t>(whole(0, static_cast<int>(moduli.size()) - 1))];
  };
  struct Centre {
    double x, y, radius;
    float modulus;
  };
  std::vector<Centre> centres(static_cast<std::size_t>(whole(4, 25)));
  for (Centre& centre : centres) {
    centre = {uniform(0, extent.width), uniform(0, extent.height), uniform(2, 0.2 * extent.width),
              any_modulus()};
  }
  const double thickness = uniform(1.0, 12.0);
  const double waves = uniform(0.0, 6.0);
  const double tilt = uniform(-1.0, 1.0);
  for_each_site(extent, [&](int x, int y) {
    float& modulus = scene.full.modulus.values[extent.index(x, y)];
    switch (varied.make) {
    case Make::blobs:
      modulus = moduli.front();
      for (const Centre& centre : centres) {
        modulus = std::hypot(x - centre.x, y - centre.y) < centre.radius ? centre.modulus : modulus;
      }
      break;
    case Make::cells: {
      double nearest = 1e9;
      for (const Centre& centre : centres) {
        const double distance = std::hypot(x - centre.x, y - centre.y);
        modulus = distance < nearest ? centre.modulus : modulus;
        nearest = std::min(nearest, distance);
      }
      break;
    }
    case Make::layers: {
      const double height = y + tilt * x + 3.0 * std::sin(waves * x / extent.width);
      const auto layer = static_cast<int>(std::floor(height / thickness));
      const auto count = static_cast<int>(moduli.size());
      modulus = moduli[static_cast<std::size_t>(((layer % count) + count) % count)];
      break;
    }
    case Make::noise:
      modulus = any_modulus();
      break;
    }
  });

  // Smooth in x and y, up to 10 pixels.
  std::array<double, 8> wave{};
  for (double& value : wave) {
    value = uniform(-1.0, 1.0);
  }
  const auto smooth = [&](int x, int y) {
    const double u = std::numbers::pi * x / extent.width;
    const double v = std::numbers::pi * y / extent.height;
    return std::pair{5.0 * (wave[0] * std::sin(u + wave[1]) + wave[2] * std::cos(v + wave[3])),
                     5.0 * (wave[4] * std::sin(v + wave[5]) + wave[6] * std::cos(u + wave[7]))};
  };
  const auto give = [&](int x, int y, double dx, double dy) {
    const std::size_t at = extent.index(x, y);
    scene.full.target.x[at] = static_cast<float>(dx);
    scene.full.target.y[at] = static_cast<float>(dy);
    scene.full.confidence.x[at] = 1.0F;
    scene.full.confidence.y[at] = 1.0F;
  };
  const int sides = whole(1, 15); // a set of four
  for_each_site(extent, [&](int x, int y) {
    const bool here = ((sides & 1) != 0 && x == 0) || ((sides & 2) != 0 && y == 0) ||
                      ((sides & 4) != 0 && x == extent.width - 1) ||
                      ((sides & 8) != 0 && y == extent.height - 1);
    if (here) {
      const auto [dx, dy] = smooth(x, y);
      give(x, y, dx, dy);
    }
  });
  if (varied.scattered) {
    const double disagreement = uniform(0.0, 3.0); // pixels
    for (int i = static_cast<int>(0.02 * static_cast<double>(extent.sites())); i > 0; --i) {
      const int x = whole(0, extent.width - 1);
      const int y = whole(0, extent.height - 1);
      const auto [dx, dy] = smooth(x, y);
      give(x, y, dx + uniform(-disagreement, disagreement), dy + uniform(-disagreement, disagreement));
    }
  }
  set_inverse_modulus(scene.full);
  set_weight(scene, {.penalty = 1e3});
  return varied;
}

} // namespace hdmbench::test
