#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/fixed_point.hpp"
#include "reference/interpolation.hpp"
#include "reference/thesis_energy.hpp"
#include "test/files.hpp"
#include "test/random_level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace hdmbench {
namespace {

using testing::HasSubstr;

/// A random level with at least one observation of each component.
Level random_level(Extent extent, test::Texture texture, std::uint64_t seed, float penalty) {
  Level level = test::random_problem(extent, texture, seed).level;
  level.penalty = penalty;
  level.confidence[0][0] = level.confidence[1][0] = 1.0F;
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
  level.target[0][i] = dx;
  level.target[1][i] = dy;
  level.confidence[0][i] = level.confidence[1][i] = confidence;
}

/// No displacement of a site alone lowers its energy; and where that is a parabola, the site is at its
/// vertex.
void expect_minima(const Level& level, const ReferenceField& field) {
  const ThesisEnergyOf<ReferenceField> energy(level, field);
  for_each_site(level.extent, [&](int x, int y) {
    const auto i = level.extent.index(x, y);
    const auto at = [&](double step) { return energy.at(x, y, {field[0][i] + step, field[1][i] + step}); };
    const auto here = at(0.0);
    for (const double step : {-1.0, -0.1, -1e-3, 1e-3, 0.1, 1.0}) {
      ASSERT_GT(at(step).x, here.x) << "x = " << x << ", y = " << y << ", step " << step;
      ASSERT_GT(at(step).y, here.y) << "x = " << x << ", y = " << y << ", step " << step;
    }
    // Observed: a parabola on this side of the target.
    const auto distance_to_vertex = [&](auto component, double d, float target, float confidence) {
      const double reach = confidence > 0.0F ? std::min(1.0, 0.5 * std::abs(d - double{target})) : 1.0;
      const double before = at(-reach).*component;
      const double after = at(reach).*component;
      return reach > 0.01 ? 0.5 * reach * (after - before) / (before + after - 2.0 * here.*component) : 0.0;
    };
    using Value = ThesisEnergyOf<ReferenceField>::Value;
    EXPECT_NEAR(distance_to_vertex(&Value::x, field[0][i], level.target[0][i], level.confidence[0][i]), 0.0,
                1e-9);
    EXPECT_NEAR(distance_to_vertex(&Value::y, field[1][i], level.target[1][i], level.confidence[1][i]), 0.0,
                1e-9);
  });
}

TEST(FixedPoint, EverySiteIsAtItsOwnMinimum) {
  for (const auto texture : {test::Texture::smooth, test::Texture::tie_rich, test::Texture::dyadic}) {
    for (const float penalty : {1e6F, 300.0F, 30.0F, 4.0F, 0.1F}) {
      SCOPED_TRACE(penalty);
      const Level level = random_level({23, 17}, texture, 11, penalty);
      expect_minima(level, solve_fixed_point(level).displacement);
    }
  }
}

TEST(FixedPoint, IterationsInDoubleStayThere) {
  for (const float penalty : {300.0F, 4.0F}) {
    Level level = random_level({31, 26}, test::Texture::smooth, 5, penalty);
    level.steps = StepSet::parse("0,-1,1,-0.1,0.1,-0.01,0.01,-0.001,0.001,-0.0001,0.0001");
    const FixedPoint fixed = solve_fixed_point(level);
    const ReferenceField next = thesis_iteration(level, fixed.displacement);
    EXPECT_EQ(next[0], fixed.displacement[0]);
    EXPECT_EQ(next[1], fixed.displacement[1]);
  }
}

TEST(FixedPoint, AHeldSetThatCyclesIsFoundOneSidedly) {
  // Newton's method alternates on this one for ever.
  const Level level = random_level({5, 4}, test::Texture::smooth, 171, 30.0F);
  const FixedPoint fixed = solve_fixed_point(level);
  EXPECT_GT(fixed.rounds, 60);
  expect_minima(level, fixed.displacement);
}

std::string refusal(const Level& level) {
  return test::refusal([&] { (void)solve_fixed_point(level); });
}

TEST(FixedPoint, LevelsWithoutAUniqueFieldAreRefused) {
  Level level = homogeneous_level({6, 5});
  EXPECT_THAT(refusal(level), HasSubstr("no site has a known displacement in x"));
  level.confidence[0][3] = 0.25F;
  EXPECT_THAT(refusal(level), HasSubstr("no site has a known displacement in y"));
  level.confidence[1][3] = 0.25F;
  EXPECT_EQ(refusal(level), "accepted");

  Level column = homogeneous_level({1, 4});
  observe(column, 0, 1, 2.0F, 1.0F);
  EXPECT_THAT(refusal(column), HasSubstr("in x at x = 0, y = 0 is not known"));
  for (int y = 0; y < 4; ++y) {
    column.confidence[0][column.extent.index(0, y)] = 1.0F;
  }
  EXPECT_EQ(refusal(column), "accepted");

  level.modulus.values[0] = -1.0F;
  EXPECT_THAT(refusal(level), HasSubstr("the modulus"));
}

/// Targets everywhere; `is_observed` says where they count.
Level level_of(Extent extent, const std::function<float(int, int)>& target,
               const std::function<bool(int, int)>& is_observed) {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent, 1.0F),
              .inverse_modulus = {}};
  set_inverse_modulus(level);
  for_each_site(extent, [&](int x, int y) {
    const auto i = extent.index(x, y);
    level.target[0][i] = target(x, y);
    level.target[1][i] = -target(x, y);
    level.confidence[0][i] = level.confidence[1][i] = is_observed(x, y) ? 0.5F : 0.0F;
  });
  return level;
}

float linear(int x, int y) {
  return 2.0F + 0.5F * static_cast<float>(x) - 0.25F * static_cast<float>(y);
}

TEST(Interpolation, LinearFieldsAreMet) {
  const Extent extent{11, 8};
  const auto on_border = [&](int x, int y) {
    return x == 0 || y == 0 || x + 1 == extent.width || y + 1 == extent.height;
  };
  const auto on_ellipse_or_border = [&](int x, int y) { return on_border(x, y) || (x + y) % 5 == 0; };
  const auto at_sides = [&](int x, int) { return x == 0 || x + 1 == extent.width; };
  for (const std::function<bool(int, int)>& where :
       std::initializer_list<std::function<bool(int, int)>>{on_border, on_ellipse_or_border, at_sides}) {
    const ReferenceField field = interpolate_conditions(level_of(extent, linear, where));
    for_each_site(extent, [&](int x, int y) {
      EXPECT_NEAR(field[0][extent.index(x, y)], static_cast<double>(linear(x, y)), 1e-14);
      EXPECT_NEAR(field[1][extent.index(x, y)], -static_cast<double>(linear(x, y)), 1e-14);
    });
  }
}

TEST(Interpolation, RowAndColumnAreBlendedByTheDistanceToTheirNearerEnds) {
  // Row 2 has 10 at both ends, 1 and 4 sites away; column 1 has 40 at both ends, 2 sites away.
  const auto where = [](int x, int y) {
    return (y == 2 && (x == 0 || x == 5)) || (x == 1 && (y == 0 || y == 4));
  };
  const Level level = level_of(
      {6, 5}, [](int x, int) { return x == 1 ? 40.0F : 10.0F; }, where);
  const ReferenceField field = interpolate_conditions(level);
  EXPECT_NEAR(field[0][level.extent.index(1, 2)], (10.0 / 1.0 + 40.0 / 2.0) / (1.0 / 1.0 + 1.0 / 2.0), 1e-13);
}

} // namespace
} // namespace hdmbench
