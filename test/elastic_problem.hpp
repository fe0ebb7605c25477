#pragma once

#include "kernels/data/level.hpp"

#include <cmath>
#include <cstdint>
#include <random>

namespace hdmbench::test {

/// What the moduli of an elastic level look like.
enum class Tissue {
  inclusion, ///< a square of a third of the sides
  noise,     ///< a modulus for every site
  layers,    ///< two sites each
  checkerboard
};
inline constexpr std::array all_tissues{Tissue::inclusion, Tissue::noise, Tissue::layers,
                                        Tissue::checkerboard};

/// Where it is held.
enum class Held {
  border,    ///< x left and right, y at top and bottom
  scattered, ///< one site in thirty, x and y apart
  supports,  ///< four sites
  regions,   ///< scattered, and everything in the left third
  springs    ///< as scattered, but by springs of all stiffnesses, and the corners for good
};
inline constexpr std::array all_held{Held::border, Held::scattered, Held::supports, Held::regions,
                                     Held::springs};

/// The same for the same arguments on every machine; moduli from 1 to `contrast` MPa, targets up to 5 px.
inline Level elastic_level(Extent extent, Tissue tissue, Held held, double contrast, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent)};
  const double turn = 6.0 * uniform();
  const auto hold = [&](int x, int y, bool in_x, bool in_y) {
    const std::size_t at = extent.index(x, y);
    const double along = static_cast<double>(x) / extent.width;
    const double down = static_cast<double>(y) / extent.height;
    level.target.x[at] = static_cast<float>(5.0 * std::sin(turn + 3.0 * along + down));
    level.target.y[at] = static_cast<float>(5.0 * std::cos(turn - along + 4.0 * down));
    level.confidence.x[at] = in_x ? 1.0F : level.confidence.x[at];
    level.confidence.y[at] = in_y ? 1.0F : level.confidence.y[at];
  };
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const bool inside = 3 * x > extent.width && 3 * x < 2 * extent.width && 3 * y > extent.height &&
                          3 * y < 2 * extent.height;
      const double share = tissue == Tissue::inclusion ? (inside ? 1.0 : 0.0)
                           : tissue == Tissue::noise   ? uniform()
                           : tissue == Tissue::layers  ? y / 2 % 2
                                                       : (x + y) % 2;
      level.modulus.values[extent.index(x, y)] = static_cast<float>(std::pow(contrast, share));
      const bool last_x = x == 0 || x + 1 == extent.width;
      const bool last_y = y == 0 || y + 1 == extent.height;
      if (held == Held::border) {
        hold(x, y, last_x, last_y);
      } else if (held != Held::supports) {
        hold(x, y, uniform() < 0.03, uniform() < 0.03);
        hold(x, y, last_x && last_y, last_x && last_y);
      }
      if (held == Held::regions && 3 * x < extent.width) {
        hold(x, y, true, true);
      }
    }
  }
  if (held == Held::springs) {
    for (auto* const confidences : {&level.confidence.x, &level.confidence.y}) {
      for (std::size_t i = 0; i < confidences->size(); ++i) {
        const bool corner = i == 0 || i + 1 == confidences->size();
        float& confidence = (*confidences)[i];
        confidence *= corner ? 1.0F : static_cast<float>(0.01 + 0.98 * uniform());
      }
    }
  }
  if (held == Held::supports) {
    for (int i = 0; i < 4; ++i) {
      hold((1 + 3 * (i % 2)) * extent.width / 5, (1 + 3 * (i / 2)) * extent.height / 5, true, true);
    }
  }
  set_inverse_modulus(level);
  return level;
}

/// A value for every component, -1 ... 1.
inline VectorField random_field(Extent extent, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  VectorField field(extent);
  for (auto* values : {&field.x, &field.y}) {
    for (float& value : *values) {
      value = static_cast<float>(2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0);
    }
  }
  return field;
}

} // namespace hdmbench::test
