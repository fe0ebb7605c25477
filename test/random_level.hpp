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

inline constexpr std::array all_rules{Rule::steps, Rule::closed_form, Rule::correction, Rule::annealing};
inline constexpr std::array simultaneous_and_coloured{Update::simultaneous, Update::coloured,
                                                      Update::four_coloured};

/// The same for the same arguments on every machine. Strengths differ from sweep to sweep. Without steps: the
/// default ones, and 1 and 0.25 for dyadic.
inline Problem random_problem(Extent extent, Texture texture, std::uint64_t seed,
                              std::optional<StepSet> steps = {}, Rule rule = Rule::steps,
                              Update update = Update::simultaneous) {
  std::mt19937_64 engine(seed);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
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
    problem.level.target.x[i] = displacement();
    problem.level.target.y[i] = displacement();
    problem.level.confidence.x[i] = confidence();
    problem.level.confidence.y[i] = confidence();
    problem.start.x[i] = displacement();
    problem.start.y[i] = displacement();
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

} // namespace hdmbench::test
