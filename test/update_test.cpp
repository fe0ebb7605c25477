// The rules, colours and random numbers of update.inc against what they are meant to be: minimisers found by
// search, a sweep in place, statistics. That all backends do the same is backends_test's affair.

#include "harness/scene/sites.hpp"
#include "kernels/data/gather.hpp"
#include "reference/thesis_energy.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using test::swept;

/// Where a convex function is lowest between low and high, to about 1e-7 of their distance.
double golden_section_search(const std::function<double(double)>& function, double low, double high) {
  const double ratio = (std::sqrt(5.0) - 1.0) / 2.0;
  for (int i = 0; i < 60; ++i) {
    const double left = high - ratio * (high - low);
    const double right = low + ratio * (high - low);
    (function(left) < function(right) ? high : low) = function(left) < function(right) ? right : left;
  }
  return (low + high) / 2.0;
}

TEST(ClosedForm, LandsOnTheMinimiserOrAsFarFromItAsTheRelaxationSays) {
  auto problem = test::random_problem({24, 24}, test::Texture::smooth, 41, {}, Rule::closed_form);
  for (const float penalty : {1.0F, 300.0F, 1e6F}) {
    problem.level.penalty = penalty;
    problem.level.strengths = {1.0F};
    const VectorField minimal = swept(problem, 1);
    problem.level.strengths = {0.25F, 1.0F};
    const VectorField quarter = swept(problem, 1);
    const ThesisEnergy energy(problem.level, problem.start);
    int pulled = 0;
    for_each_site(problem.level.extent, [&](int x, int y) {
      if (x % 23 != 0 && y % 23 != 0) {
        const HdmInFloat::Site site = gather<HdmInFloat>(problem.level, problem.start, x, y);
        const std::size_t at = problem.level.extent.index(x, y);
        // Between the outermost neighbours and the target lies the minimiser.
        const double lowest = golden_section_search(
            [&](double d) {
              return energy.at(x, y, {d, 0.0}).x;
            },
            -11, 11);
        EXPECT_NEAR(minimal[0][at], lowest, 2e-5) << "K = " << penalty << ", " << x << ", " << y;
        pulled += site.confidence_x > 0.0F && minimal[0][at] != site.target_x ? 1 : 0;
        if (site.confidence_x == 0.0F) {
          EXPECT_NEAR(quarter[0][at], site.dx.centre + 0.25 * (lowest - site.dx.centre), 2e-5);
        }
      }
    });
    EXPECT_EQ(pulled > 0, penalty < 1e6F) << "both sides of the threshold are to be seen";
  }
}

TEST(ClosedForm, AHeldComponentTakesTheTargetItselfAtAnyRelaxation) {
  auto problem = test::random_problem({40, 40}, test::Texture::smooth, 42, {}, Rule::closed_form);
  problem.level.penalty = 1e7F;
  for (const float relaxation : {0.3F, 1.0F, 1.9F}) {
    problem.level.strengths = {relaxation};
    const VectorField field = swept(problem, 1);
    for (std::size_t i = 0; i < field[0].size(); ++i) {
      if (problem.level.confidence[0][i] > 0.01F) {
        ASSERT_EQ(field[0][i], problem.level.target[0][i]) << i << ", relaxation " << relaxation;
      }
    }
  }
}

/// The sites of a sweep one after the other, in place, from last to first: the same only if nobody who moves
/// sees another one who does.
template <typename InFloat>
void sweep_in_place_backwards(const Level& level, int number, VectorField& field) {
  const Extent extent = level.extent;
  for (int row = extent.rows() - 1; row >= 0; --row) {
    for (int x = extent.width - 1; x >= 0; --x) {
      const auto moved =
          swept_site<InFloat>(level, field, number, x, row % extent.height, row / extent.height);
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        field[axis][extent.index(x, row)] = moved.*InFloat::of_axis[axis].moved;
      }
    }
  }
}

TEST(Colours, WhatMovesDoesNotSeeWhatElseMoves) {
  for (const Update update : {Update::simultaneous, Update::coloured, Update::four_coloured}) {
    for (const Extent extent : {Extent{33, 34}, {9, 6, 7}}) {
      const auto problem =
          test::random_problem(extent, test::Texture::smooth, 44, {}, Rule::closed_form, update);
      VectorField field = problem.start;
      for (int number = 0; number < sweeps_per_iteration(problem.level); ++number) {
        extent.axes() > 2 ? sweep_in_place_backwards<Hdm<float, 3>>(problem.level, number, field)
                          : sweep_in_place_backwards<HdmInFloat>(problem.level, number, field);
      }
      const VectorField expected = swept(problem, sweeps_per_iteration(problem.level));
      EXPECT_EQ(field.planes == expected.planes, update != Update::simultaneous);
    }
  }
}

constexpr int side = 256; ///< of the grid of random numbers

/// The numbers that a sweep draws, first and second, site by site.
std::array<std::vector<double>, 2> draws(int number, int component, int seed) {
  std::array<std::vector<double>, 2> all;
  const HdmInFloat::Sweep sweep{0.0F, 0.0F, static_cast<float>(number), static_cast<float>(seed)};
  for_each_site({side, side}, [&](int x, int y) {
    const HdmInFloat::RandomPair pair = HdmInFloat::random_pair(
        {static_cast<float>(x), static_cast<float>(y)}, sweep, static_cast<float>(component));
    all[0].push_back(pair.first);
    all[1].push_back(pair.second);
  });
  return all;
}

/// Of two series of numbers uniform in (0, 1); `shift` sites apart.
double correlation(const std::vector<double>& a, const std::vector<double>& b, std::size_t shift = 0) {
  double sum = 0.0;
  for (std::size_t i = shift; i < a.size(); ++i) {
    sum += 12.0 * (a[i] - 0.5) * (b[i - shift] - 0.5);
  }
  return sum / static_cast<double>(a.size() - shift);
}

TEST(RandomNumbers, AreUniform) {
  constexpr int bins = 64;
  for (const int number : {0, 1, 4095, 4096, 1000000}) {
    for (const auto& values : draws(number, number % 2, 7)) {
      std::array<int, bins> counts{};
      for (const double value : values) {
        ASSERT_TRUE(value > 0.0 && value < 1.0);
        ++counts[static_cast<std::size_t>(value * bins)];
      }
      const double expected = static_cast<double>(values.size()) / bins;
      double chi_square = 0.0;
      for (const int count : counts) {
        chi_square += (count - expected) * (count - expected) / expected;
      }
      // 63 degrees of freedom: mean 63, standard deviation 11.2. Far below would be a lattice.
      EXPECT_GT(chi_square, 25.0) << number;
      EXPECT_LT(chi_square, 120.0) << number;
    }
  }
}

TEST(RandomNumbers, AreUncorrelated) {
  const double five_sigma = 5.0 / side; // of a correlation over side^2 sites
  const auto drawn = draws(10, 0, 7);
  EXPECT_NEAR(correlation(drawn[0], drawn[0]), 1.0, 0.02) << "the measure itself";
  EXPECT_LT(std::abs(correlation(drawn[0], drawn[1])), five_sigma) << "first and second";
  for (const std::size_t shift : {1, 2, side - 1, side, side + 1, 2 * side}) {
    EXPECT_LT(std::abs(correlation(drawn[0], drawn[0], shift)), five_sigma) << "sites " << shift << " apart";
    EXPECT_LT(std::abs(correlation(drawn[1], drawn[1], shift)), five_sigma) << "sites " << shift << " apart";
  }
  for (const auto& other : {draws(11, 0, 7), draws(12, 0, 7), draws(10 + 4093, 0, 7), draws(10 + 4096, 0, 7),
                            draws(10, 1, 7), draws(10, 0, 8)}) {
    EXPECT_LT(std::abs(correlation(drawn[0], other[0])), five_sigma) << "sweep, component or seed";
    EXPECT_LT(std::abs(correlation(drawn[1], other[1])), five_sigma) << "sweep, component or seed";
  }
}

TEST(RandomNumbers, OfSlicesAreUncorrelated) {
  using InVolume = Hdm<float, 3>;
  std::array<std::vector<double>, 3> slices;
  for (int z = 0; z < 3; ++z) {
    for (int i = 0; i < side * side; ++i) {
      const auto pair = InVolume::random_pair(InVolume::position_of(i % side, i / side, z),
                                              {0.0F, 0.0F, 10.0F, 7.0F}, 2.0F);
      slices[static_cast<std::size_t>(z)].push_back(pair.first);
    }
  }
  const double five_sigma = 5.0 / side;
  EXPECT_LT(std::abs(correlation(slices[0], slices[1])), five_sigma);
  EXPECT_LT(std::abs(correlation(slices[0], slices[2])), five_sigma);
  EXPECT_LT(std::abs(correlation(slices[1], slices[2], 1)), five_sigma);
}

TEST(Annealing, TakesACandidateWithTheProbabilityOfItsEnergy) {
  // Everything at rest and alike: half the second derivative of U_t is 24 everywhere.
  test::Problem problem{.level = test::plain_level({side, side}), .start = VectorField({side, side})};
  problem.level.rule = Rule::annealing;
  problem.level.steps = StepSet::parse("0,0.1");
  problem.level.seed = 9;
  for (const double inverse_temperature : {0.0, 1.0, 4.0, 15.0}) {
    problem.level.strengths = {static_cast<float>(inverse_temperature)};
    const VectorField field = swept(problem, 1);
    const double draws = 2.0 * side * side;
    const double taken =
        static_cast<double>(std::ranges::count_if(field[0], [](float d) { return d != 0.0F; }) +
                            std::ranges::count_if(field[1], [](float d) { return d != 0.0F; }));
    const double exponent = 24.0 * 0.1 * 0.1 * inverse_temperature;
    const double probability = 0.5 * std::exp(-exponent);
    const double five_sigma = 5.0 * std::sqrt(probability * (1.0 - probability) / draws);
    EXPECT_NEAR(taken / draws, probability, five_sigma + probability * exponent * exponent / 512.0)
        << inverse_temperature;
  }
}

/// Goes through a sweep in place site by site, in double.
TEST(SequentialIcm, EverySiteTakesTheCandidateOfItsLowestEnergy) {
  for (const Extent extent : {Extent{1, 1}, {1, 6}, {7, 1}, {2, 3}, {8, 8}, {24, 17}}) {
    const auto problem =
        test::random_problem(extent, test::Texture::dyadic, 4, {}, Rule::steps, Update::sequential);
    const VectorField after = swept(problem, 1);
    VectorField field = problem.start;
    const ThesisEnergy energy(problem.level, field);
    for_each_site(extent, [&](int x, int y) {
      const std::size_t at = extent.index(x, y);
      const auto found = energy.at(x, y, {after[0][at], after[1][at]});
      for (const float step : problem.level.steps.values()) { // 0 is one of them: not above where it stood
        const auto other =
            energy.at(x, y, {double{field[0][at]} + double{step}, double{field[1][at]} + double{step}});
        ASSERT_LE(found.x, other.x) << x << ", " << y << ", step " << step;
        ASSERT_LE(found.y, other.y) << x << ", " << y << ", step " << step;
      }
      field[0][at] = after[0][at];
      field[1][at] = after[1][at];
    });
  }
}

/// Lengths in another unit give the same field in that unit, to the bit where the unit is a power of two.
TEST(EveryRule, HasNoUnitOfLengthOrModulus) {
  const auto scale = [](VectorField& field, float factor) {
    for (auto* const values : {&field[0], &field[1]}) {
      std::ranges::for_each(*values, [factor](float& value) { value *= factor; });
    }
  };
  for (const Rule rule : test::all_rules) {
    for (const Update update : test::simultaneous_and_coloured) {
      for (const float factor : {0.25F, -1024.0F}) {
        const auto problem = test::random_problem({13, 10}, test::Texture::smooth, 3, {}, rule, update);
        auto other = problem;
        scale(other.start, factor);
        scale(other.level.target, factor);
        std::vector<float> steps(problem.level.steps.values().begin(), problem.level.steps.values().end());
        std::ranges::for_each(steps, [factor](float& step) { step *= factor; });
        other.level.steps = StepSet(steps);
        other.level.penalty *= std::abs(factor); // energies are squares of lengths
        if (rule == Rule::annealing) {
          std::ranges::for_each(other.level.strengths, [factor](float& one) { one /= factor * factor; });
        }
        std::ranges::for_each(other.level.modulus.values, [](float& value) { value *= 4096.0F; });
        set_inverse_modulus(other.level);
        set_inverse_curvature(other.level);
        VectorField expected = swept(problem, 8);
        scale(expected, factor);
        EXPECT_EQ(compare(expected, swept(other, 8)).sites, 0) << static_cast<int>(rule) << ", " << factor;
      }
    }
  }
}

} // namespace
} // namespace hdmbench
