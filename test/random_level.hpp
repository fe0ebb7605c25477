#pragma once

#include "kernels/data/level.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>

namespace hdmbench::test {

/// What the numbers of a random level look like.
enum class Texture {
  smooth,   ///< any float: hides most mistakes
  tie_rich, ///< modulus 1, all on a 0.1 grid: candidates nearly tie everywhere, exposes rounding
  dyadic,   ///< moduli 1, 2 and 4, all on a 0.25 grid: candidates tie to the bit, and where Rule::steps
            ///< chooses between candidates on that grid every operation is exact (exact_test)
  extreme,  ///< displacements of 1e-9 ... 1e9 pixels side by side, moduli of 1e-4 ... 1e4: sums lose terms
  tiny      ///< displacements below 1e-38: subnormal numbers, which some devices take for 0
};

struct Problem {
  Level level;
  VectorField start;
};

/// One modulus, nothing observed; what is done to it makes the level of a test.
inline Level plain_level(Extent extent, float modulus = 1.0F, float penalty = 1000.0F) {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent, modulus),
              .penalty = penalty};
  set_inverse_modulus(level);
  return level;
}

inline constexpr std::array all_rules{Rule::steps, Rule::closed_form, Rule::annealing};
inline constexpr std::array simultaneous_and_coloured{Update::simultaneous, Update::coloured,
                                                      Update::four_coloured};

/// Numbers in [0, 1), the same for the same seed on every machine.
class Uniform {
public:
  explicit Uniform(std::uint64_t seed) : engine_(seed) {}
  double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

private:
  std::mt19937_64 engine_;
};

/// The same for the same arguments on every machine. Strengths differ from sweep to sweep. Without steps: the
/// default ones, and 1 and 0.25 for dyadic.
inline Problem random_problem(Extent extent, Texture texture, std::uint64_t seed,
                              std::optional<StepSet> steps = {}, Rule rule = Rule::steps,
                              Update update = Update::simultaneous) {
  Uniform uniform(seed);
  // Of either sign, 2^-bits <= |value| < 2^bits, each power of two as likely as the others.
  const auto spread = [&](int bits) {
    const int exponent = static_cast<int>(std::floor(2 * bits * uniform())) - bits;
    const double value = std::ldexp(1.0 + uniform(), exponent);
    return uniform() < 0.5 ? value : -value;
  };
  const double grid = texture == Texture::tie_rich ? 0.1 : texture == Texture::dyadic ? 0.25 : 0.0;
  const auto displacement = [&] {
    if (texture == Texture::extreme) {
      return static_cast<float>(spread(30));
    }
    const double value = (texture == Texture::tiny ? 1e-38 : 10.0) * (2.0 * uniform() - 1.0);
    return static_cast<float>(grid > 0.0 ? grid * std::round(value / grid) : value);
  };
  const auto confidence = [&] {
    const double draw = uniform();
    const double partial = texture == Texture::dyadic ? 0.5 : uniform();
    return static_cast<float>(draw < 0.1 ? 1.0 : draw < 0.2 ? partial : 0.0);
  };
  Problem problem{.level = {.extent = extent,
                            .target = VectorField(extent),
                            .confidence = VectorField(extent),
                            .modulus = ScalarField(extent, 1.0F),
                            .inverse_modulus = {},
                            .penalty = texture == Texture::smooth ? 300.0F : 4.0F,
                            .steps = steps                        ? *steps
                                     : texture == Texture::dyadic ? StepSet::parse("0,-1,-0.25,1,0.25")
                                                                  : StepSet(),
                            .update = update,
                            .rule = rule,
                            .seed = static_cast<int>(seed % 4093)},
                  .start = VectorField(extent)};
  if (texture == Texture::extreme) {
    problem.level.penalty = static_cast<float>(std::abs(spread(30)));
  }
  for (std::size_t i = 0; i < extent.sites(); ++i) {
    if (texture == Texture::smooth) {
      problem.level.modulus.values[i] = static_cast<float>(1.0 + 50.0 * uniform());
    } else if (texture == Texture::dyadic) {
      problem.level.modulus.values[i] = static_cast<float>(1 << static_cast<int>(3.0 * uniform()));
    } else if (texture == Texture::extreme) {
      problem.level.modulus.values[i] = static_cast<float>(std::abs(spread(13)));
    }
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      problem.level.target[axis][i] = displacement();
    }
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      problem.level.confidence[axis][i] = confidence();
    }
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      problem.start[axis][i] = displacement();
    }
  }
  set_inverse_modulus(problem.level);
  set_inverse_curvature(problem.level);
  if (rule == Rule::annealing) {
    problem.level.strengths = {0.01F, 0.3F, 2.0F, 0.05F, 50.0F};
  } else if (rule != Rule::steps) {
    problem.level.strengths = {1.0F, 1.7F, 0.6F, 1.9F, 1.3F, 1.0F, 1.1F};
  }
  return problem;
}

// ---- Of the elastic energy

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
  Uniform uniform(seed);
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent)};
  const double turn = 6.0 * uniform();
  const std::size_t axes = extent.axes();
  using Held3 = std::array<bool, 3>;
  const auto hold = [&](int x, int y, int z, const Held3& holds) {
    const std::size_t at = extent.index(x, y, z);
    const double along = static_cast<double>(x) / extent.width;
    const double down = static_cast<double>(y) / extent.height;
    const double deep = axes == 3 ? static_cast<double>(z) / extent.depth : 0.0;
    const std::array<double, 3> target{std::sin(turn + 3.0 * along + down + deep),
                                       std::cos(turn - along + 4.0 * down - 2.0 * deep),
                                       std::sin(2.0 * turn - along + down - 3.0 * deep)};
    for (std::size_t axis = 0; axis < axes; ++axis) {
      level.target[axis][at] = static_cast<float>(5.0 * target[axis]);
      level.confidence[axis][at] = holds[axis] ? 1.0F : level.confidence[axis][at];
    }
  };
  const auto is_inside = [](int at, int side) { return 3 * at > side && 3 * at < 2 * side; };
  for (int z = 0; z < extent.depth; ++z) {
    for (int y = 0; y < extent.height; ++y) {
      for (int x = 0; x < extent.width; ++x) {
        const bool inside = is_inside(x, extent.width) && is_inside(y, extent.height) &&
                            (axes == 2 || is_inside(z, extent.depth));
        const double share = tissue == Tissue::inclusion ? (inside ? 1.0 : 0.0)
                             : tissue == Tissue::noise   ? uniform()
                             : tissue == Tissue::layers  ? (axes == 3 ? z : y) / 2 % 2
                                                         : (x + y + z) % 2;
        level.modulus.values[extent.index(x, y, z)] = static_cast<float>(std::pow(contrast, share));
        const Held3 last{x == 0 || x + 1 == extent.width, y == 0 || y + 1 == extent.height,
                         z == 0 || z + 1 == extent.depth};
        const bool corner = last[0] && last[1] && last[2];
        if (held == Held::border) {
          hold(x, y, z, last);
        } else if (held != Held::supports) {
          Held3 scattered{};
          for (std::size_t axis = axes; axis-- > 0;) {
            scattered[axis] = uniform() < 0.03;
          }
          hold(x, y, z, scattered);
          hold(x, y, z, {corner, corner, corner});
        }
        if (held == Held::regions && 3 * x < extent.width) {
          hold(x, y, z, {true, true, true});
        }
      }
    }
  }
  if (held == Held::springs) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      for (std::size_t i = 0; i < extent.sites(); ++i) {
        const bool corner = i == 0 || i + 1 == extent.sites();
        level.confidence[axis][i] *= corner ? 1.0F : static_cast<float>(0.01 + 0.98 * uniform());
      }
    }
  }
  if (held == Held::supports) {
    for (int i = 0; i < 4; ++i) {
      hold((1 + 3 * (i % 2)) * extent.width / 5, (1 + 3 * (i / 2)) * extent.height / 5,
           i % 2 * (extent.depth - 1), {true, true, true});
    }
  }
  set_inverse_modulus(level);
  return level;
}

/// A value for every component, -1 ... 1.
inline VectorField random_field(Extent extent, std::uint64_t seed) {
  Uniform uniform(seed);
  VectorField field(extent);
  for (std::vector<float>& values : field.planes) {
    for (float& value : values) {
      value = static_cast<float>(2.0 * uniform() - 1.0);
    }
  }
  return field;
}

} // namespace hdmbench::test
