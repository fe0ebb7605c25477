#include "harness/scene/sites.hpp"
#include "reference/fixed_point.hpp"
#include "reference/thesis_energy.hpp"
#include "reference/thesis_icm.hpp"
#include "test/files.hpp"
#include "test/random_level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace hdmbench {
namespace {

using testing::HasSubstr;

/// A random level with at least one observation of each component.
Level random_level(Extent extent, test::Texture texture, std::uint64_t seed, float penalty) {
  Level level = test::random_problem(extent, texture, seed).level;
  level.penalty = penalty;
  level.confidence.x[0] = level.confidence.y[0] = 1.0F;
  return level;
}

Level homogeneous_level(Extent extent) {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent, 3.0F),
              .inverse_modulus = {},
              .penalty = 1000.0F};
  set_inverse_modulus(level);
  return level;
}

void observe(Level& level, int x, int y, float dx, float dy, float confidence = 1.0F) {
  const auto i = level.extent.index(x, y);
  level.target.x[i] = dx;
  level.target.y[i] = dy;
  level.confidence.x[i] = level.confidence.y[i] = confidence;
}

TEST(FixedPoint, EverySiteIsAtItsOwnMinimum) {
  for (const auto texture : {test::Texture::smooth, test::Texture::tie_rich, test::Texture::dyadic}) {
    for (const float penalty : {1e6F, 300.0F, 30.0F, 4.0F, 0.1F}) {
      const Level level = random_level({23, 17}, texture, 11, penalty);
      const FixedPoint fixed = solve_fixed_point(level);
      EXPECT_LT(fixed.residual, 1e-9) << "K " << penalty;
      const ThesisEnergyOf<ReferenceField> energy(level, fixed.displacement);
      for (int y = 0; y < level.extent.height; ++y) {
        for (int x = 0; x < level.extent.width; ++x) {
          const auto i = level.extent.index(x, y);
          const auto at = energy.at(x, y);
          for (const double step : {-1.0, -0.1, -1e-3, 1e-3, 0.1, 1.0}) {
            const auto moved =
                energy.at(x, y, {fixed.displacement.x[i] + step, fixed.displacement.y[i] + step});
            ASSERT_GT(moved.x, at.x) << "x = " << x << ", y = " << y << ", K " << penalty << ", step "
                                     << step;
            ASSERT_GT(moved.y, at.y) << "x = " << x << ", y = " << y << ", K " << penalty << ", step "
                                     << step;
          }
        }
      }
    }
  }
}

TEST(FixedPoint, IterationsInDoubleStayThere) {
  for (const float penalty : {300.0F, 4.0F}) {
    Level level = random_level({31, 26}, test::Texture::smooth, 5, penalty);
    level.steps = StepSet::parse("0,-1,1,-0.1,0.1,-0.01,0.01,-0.001,0.001,-0.0001,0.0001");
    const FixedPoint fixed = solve_fixed_point(level);
    const ReferenceField next = thesis_iteration(level, fixed.displacement);
    EXPECT_EQ(next.x, fixed.displacement.x);
    EXPECT_EQ(next.y, fixed.displacement.y);
  }
}

TEST(FixedPoint, IterationsInDoubleLeaveAFieldBesideIt) {
  Level level = random_level({9, 9}, test::Texture::smooth, 5, 300.0F);
  level.steps = StepSet::parse("0,-0.001,0.001");
  ReferenceField displacement = solve_fixed_point(level).displacement;
  for (double& value : displacement.x) {
    value += 0.002;
  }
  EXPECT_NE(thesis_iteration(level, displacement).x, displacement.x);
}

/// +1 and -1: where the observation pulls to from d.
int side_of(double displacement, float target) {
  const double way = static_cast<double>(target) - displacement;
  return std::abs(way) < 1e-9 ? 0 : way > 0.0 ? 1 : -1;
}

TEST(FixedPoint, HeldAndPulledComponentsObeyTheSignRule) {
  for (const float penalty : {300.0F, 30.0F, 4.0F}) {
    const Level level = random_level({19, 14}, test::Texture::smooth, 8, penalty);
    const FixedPoint fixed = solve_fixed_point(level);
    Level unobserved = level;
    unobserved.confidence = VectorField(level.extent);
    const ThesisEnergyOf<ReferenceField> energy(unobserved, fixed.displacement);
    std::size_t held = 0;
    std::size_t pulled = 0;
    for_each_site(level.extent, [&](int x, int y) {
      const auto i = level.extent.index(x, y);
      const double d = fixed.displacement.x[i];
      // The derivative of the energy of the triples, exact for a parabola.
      const double slope = 0.5 * (energy.at(x, y, {d + 1.0, 0.0}).x - energy.at(x, y, {d - 1.0, 0.0}).x);
      const double pull = static_cast<double>(penalty) * static_cast<double>(level.confidence.x[i]);
      const int side = side_of(d, level.target.x[i]);
      const double tolerance = 1e-7;
      if (pull == 0.0) {
        EXPECT_NEAR(slope, 0.0, tolerance);
      } else if (side == 0) {
        EXPECT_LE(std::abs(slope), pull + tolerance);
        ++held;
      } else {
        EXPECT_NEAR(slope, side * pull, tolerance) << "x = " << x << ", y = " << y;
        ++pulled;
      }
    });
    EXPECT_GT(held, 0U) << "K " << penalty;
    EXPECT_GT(pulled, 0U) << "K " << penalty;
  }
}

TEST(FixedPoint, CountsWhatIsHeld) {
  Level level = homogeneous_level({6, 5});
  observe(level, 0, 2, -3.0F, 1.0F);
  observe(level, 5, 2, 4.0F, -1.0F);
  EXPECT_EQ(solve_fixed_point(level).held, 4U);
  EXPECT_EQ(solve_fixed_point(level).rounds, 1);
  // So weak that one of the two alone can be held; which one, the greater confidence says.
  observe(level, 5, 2, 4.0F, -1.0F, 0.5F);
  level.penalty = 0.01F;
  const FixedPoint weak = solve_fixed_point(level);
  EXPECT_EQ(weak.held, 2U);
  EXPECT_EQ(weak.displacement.x[level.extent.index(0, 2)], -3.0);
  EXPECT_GT(weak.displacement.x[level.extent.index(5, 2)], -3.0);
  EXPECT_LT(weak.displacement.x[level.extent.index(5, 2)], -2.9);
}

TEST(FixedPoint, LinearFieldsAreMetInAHomogeneousMedium) {
  // All of the border known: any linear field. Left and right known: linear in x only, as what a border site
  // sees of a field linear in y is not symmetric.
  Level all = homogeneous_level({12, 9});
  Level sides = homogeneous_level({12, 9});
  const auto dx = [](int x, int y) { return 0.5F * static_cast<float>(x) - 0.25F * static_cast<float>(y); };
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 12; ++x) {
      if (x == 0 || y == 0 || x == 11 || y == 8) {
        observe(all, x, y, dx(x, y), -dx(x, y));
      }
      if (x == 0 || x == 11) {
        observe(sides, x, y, dx(x, 0), 1.0F);
      }
    }
  }
  const ReferenceField in_all = solve_fixed_point(all).displacement;
  const ReferenceField in_sides = solve_fixed_point(sides).displacement;
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 12; ++x) {
      const auto i = all.extent.index(x, y);
      EXPECT_NEAR(in_all.x[i], static_cast<double>(dx(x, y)), 1e-12);
      EXPECT_NEAR(in_all.y[i], -static_cast<double>(dx(x, y)), 1e-12);
      EXPECT_NEAR(in_sides.x[i], static_cast<double>(dx(x, 0)), 1e-12);
      EXPECT_NEAR(in_sides.y[i], 1.0, 1e-12);
    }
  }
}

TEST(FixedPoint, ManyRandomHeldSetsSettle) {
  int most_rounds = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    for (const auto texture : {test::Texture::smooth, test::Texture::tie_rich, test::Texture::dyadic}) {
      for (const float penalty : {300.0F, 30.0F, 4.0F, 0.5F, 0.01F}) {
        const Extent extent{2 + static_cast<int>(seed * 5 % 13), 2 + static_cast<int>(seed * 3 % 11)};
        const FixedPoint fixed = solve_fixed_point(random_level(extent, texture, seed, penalty));
        EXPECT_LT(fixed.residual, 1e-9) << "seed " << seed << ", K " << penalty;
        EXPECT_GE(fixed.held, 2U);
        most_rounds = std::max(most_rounds, fixed.rounds);
      }
    }
  }
  EXPECT_GT(most_rounds, 5) << "nothing here was hard to settle";
  EXPECT_LT(most_rounds, 60) << "one of these needed the slow way";
}

TEST(FixedPoint, AHeldSetThatCyclesIsFoundOneSidedly) {
  // Newton's method alternates on this one for ever.
  const FixedPoint fixed = solve_fixed_point(random_level({5, 4}, test::Texture::smooth, 171, 30.0F));
  EXPECT_GT(fixed.rounds, 60);
  EXPECT_LT(fixed.residual, 1e-9);
}

std::string refusal(const Level& level) {
  return test::refusal([&] { (void)solve_fixed_point(level); });
}

TEST(FixedPoint, LevelsWithoutAUniqueFieldAreRefused) {
  Level level = homogeneous_level({6, 5});
  EXPECT_THAT(refusal(level), HasSubstr("no site has a known displacement in x"));
  level.confidence.x[3] = 0.25F;
  EXPECT_THAT(refusal(level), HasSubstr("no site has a known displacement in y"));
  level.confidence.y[3] = 0.25F;
  EXPECT_EQ(refusal(level), "accepted");

  Level column = homogeneous_level({1, 4});
  observe(column, 0, 1, 2.0F, 1.0F);
  EXPECT_THAT(refusal(column), HasSubstr("in x at x = 0, y = 0 is not known"));
  for (int y = 0; y < 4; ++y) {
    column.confidence.x[column.extent.index(0, y)] = 1.0F;
  }
  EXPECT_EQ(refusal(column), "accepted");

  level.modulus.values[0] = -1.0F;
  EXPECT_THAT(refusal(level), HasSubstr("the modulus"));
}

} // namespace
} // namespace hdmbench
