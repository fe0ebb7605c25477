// The rules, colours and random numbers of update.inc against what they are meant to be, in images and in
// volumes: minimisers, a sweep in place, independence. Golden hashes hold what images have, and backends_test
// that all backends do the same.

#include "harness/scene/sites.hpp"
#include "kernels/data/gather.hpp"
#include "reference/thesis_energy.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using test::swept;

TEST(ClosedForm, LandsOnTheMinimiserOrAsFarFromItAsTheRelaxationSays) {
  for (const Extent extent : {Extent{24, 24}, {9, 6, 7}}) {
    auto problem = test::random_problem(extent, test::Texture::smooth, 41, {}, Rule::closed_form);
    for (const float penalty : {1.0F, 300.0F, 1e7F}) {
      problem.level.penalty = penalty;
      problem.level.strengths = {1.0F};
      const VectorField minimal = swept(problem, 1);
      problem.level.strengths = {0.25F, 1.0F};
      const VectorField quarter = swept(problem, 1);
      const ThesisEnergy energy(problem.level, problem.start);
      for_each_site(extent, [&](int x, int y, int z) {
        const std::size_t site = extent.index(x, y, z);
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          const double centre = double{problem.start[axis][site]};
          const double lowest = double{minimal[axis][site]};
          const auto at = [&](double displacement) {
            std::array<double, 3> to{};
            to[axis] = displacement;
            const auto value = energy.at(x, y, {to[0], to[1], to[2]}, z);
            return std::array{value.x, value.y, value.z}[axis];
          };
          for (const double step : {-1e-3, 1e-3}) { // a curvature of 1 at least outweighs the rounding
            EXPECT_LT(at(lowest), at(lowest + step)) << x << ", " << y << ", " << z << ", K = " << penalty;
          }
          if (problem.level.confidence[axis][site] == 0.0F) {
            EXPECT_NEAR(quarter[axis][site], centre + 0.25 * (lowest - centre), 2e-5);
          } else if (penalty > 1e6F &&
                     problem.level.confidence[axis][site] > 0.1F) { // held at any relaxation
            EXPECT_EQ(quarter[axis][site], problem.level.target[axis][site]);
          }
        }
      });
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

/// Between sites that are `shift` apart, of numbers uniform in (0, 1).
double correlation(const std::vector<double>& a, const std::vector<double>& b, std::size_t shift = 0) {
  double sum = 0.0;
  for (std::size_t i = shift; i < a.size(); ++i) {
    sum += 12.0 * (a[i] - 0.5) * (b[i - shift] - 0.5);
  }
  return sum / static_cast<double>(a.size() - shift);
}

TEST(RandomNumbers, OfSlicesSweepsComponentsAndSeedsAreUncorrelated) {
  constexpr int side = 256;
  const auto draws = [](int z, float number, float component, float seed) {
    using InVolume = Hdm<float, 3>;
    std::vector<double> first;
    for_each_site({side, side}, [&](int x, int y) {
      first.push_back(
          InVolume::random_pair(InVolume::position_of(x, y, z), {0.0F, 0.0F, number, seed}, component).first);
    });
    return first;
  };
  const std::vector<double> drawn = draws(0, 10.0F, 2.0F, 7.0F);
  const double five_sigma = 5.0 / side; // of a correlation over side^2 sites
  EXPECT_NEAR(correlation(drawn, drawn), 1.0, 0.02) << "the measure itself";
  for (const std::size_t shift : {1, 2, side - 1, side, side + 1}) {
    EXPECT_LT(std::abs(correlation(drawn, drawn, shift)), five_sigma) << "sites " << shift << " apart";
  }
  for (const auto& other :
       {draws(1, 10.0F, 2.0F, 7.0F), draws(2, 10.0F, 2.0F, 7.0F), draws(0, 11.0F, 2.0F, 7.0F),
        draws(0, 10.0F + 4093.0F, 2.0F, 7.0F), draws(0, 10.0F + 4096.0F, 2.0F, 7.0F),
        draws(0, 10.0F, 1.0F, 7.0F), draws(0, 10.0F, 2.0F, 8.0F)}) {
    EXPECT_LT(std::abs(correlation(drawn, other)), five_sigma);
    EXPECT_LT(std::abs(correlation(drawn, other, 1)), five_sigma);
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
