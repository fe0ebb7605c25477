#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/fixed_point.hpp"
#include "reference/interpolation.hpp"
#include "reference/thesis_energy.hpp"
#include "test/files.hpp"
#include "test/random_level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

namespace hdmbench {
namespace {

using testing::HasSubstr;

/// A random level with at least one observation of each component.
Level random_level(Extent extent, test::Texture texture, std::uint64_t seed, float penalty) {
  Level level = test::random_problem(extent, texture, seed).level;
  level.penalty = penalty;
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    level.confidence[axis][0] = 1.0F;
  }
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
  for_each_site(level.extent, [&](int x, int y, int z) {
    const auto i = level.extent.index(x, y, z);
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      const auto at = [&](double step) {
        std::array<double, 3> d{};
        for (std::size_t each = 0; each < level.extent.axes(); ++each) {
          d[each] = field[each][i] + step;
        }
        const auto value = energy.at(x, y, {d[0], d[1], d[2]}, z);
        return std::array{value.x, value.y, value.z}[axis];
      };
      const double here = at(0.0);
      for (const double step : {-1.0, -0.1, -1e-3, 1e-3, 0.1, 1.0}) {
        ASSERT_GT(at(step), here) << level.extent.place(i) << ", axis " << axis << ", step " << step;
      }
      // Observed: a parabola on this side of the target.
      const bool observed = level.confidence[axis][i] > 0.0F;
      const double way = std::abs(field[axis][i] - double{level.target[axis][i]});
      const double reach = observed ? std::min(1.0, 0.5 * way) : 1.0;
      const double before = at(-reach);
      const double after = at(reach);
      const double to_vertex =
          reach > 0.01 ? 0.5 * reach * (after - before) / (before + after - 2.0 * here) : 0.0;
      EXPECT_NEAR(to_vertex, 0.0, 1e-9);
    }
  });
}

TEST(FixedPoint, EverySiteIsAtItsOwnMinimum) {
  for (const auto texture : {test::Texture::smooth, test::Texture::tie_rich, test::Texture::dyadic}) {
    for (const float penalty : {1e6F, 300.0F, 30.0F, 4.0F, 0.1F}) {
      SCOPED_TRACE(penalty);
      for (const Extent extent : {Extent{23, 17}, {7, 6, 5}}) {
        const Level level = random_level(extent, texture, 11, penalty);
        expect_minima(level, solve_fixed_point(level).displacement);
      }
    }
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

using Where = std::function<bool(int x, int y, int z)>;

/// Targets everywhere; `is_observed` says where they count.
Level level_of(Extent extent, const std::function<float(int x, int y, int z)>& target,
               const Where& is_observed) {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent, 1.0F),
              .inverse_modulus = {}};
  set_inverse_modulus(level);
  for_each_site(extent, [&](int x, int y, int z) {
    const auto i = extent.index(x, y, z);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      level.target[axis][i] = (axis == 1 ? -1.0F : 1.0F) * target(x, y, z);
      level.confidence[axis][i] = is_observed(x, y, z) ? 0.5F : 0.0F;
    }
  });
  return level;
}

TEST(Interpolation, LinearFieldsAreMet) {
  const auto linear = [](int x, int y, int z) {
    return 2.0F + 0.5F * static_cast<float>(x) - 0.25F * static_cast<float>(y) +
           0.75F * static_cast<float>(z);
  };
  for (const Extent extent : {Extent{11, 8}, {7, 6, 5}}) {
    const Where at_sides = [&](int x, int, int) { return x == 0 || x + 1 == extent.width; };
    const Where on_border = [&](int x, int y, int z) {
      return at_sides(x, y, z) || y == 0 || y + 1 == extent.height;
    };
    const Where on_planes_too = [&](int x, int y, int z) {
      return on_border(x, y, z) || (x + y + z) % 5 == 0;
    };
    for (const Where& where : {on_border, on_planes_too, at_sides}) {
      const Level level = level_of(extent, linear, where);
      const ReferenceField field = interpolate_conditions(level);
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        for (std::size_t i = 0; i < extent.sites(); ++i) {
          EXPECT_NEAR(field[axis][i], static_cast<double>(level.target[axis][i]), 1e-14) << extent.place(i);
        }
      }
    }
  }
}

TEST(Interpolation, RowAndColumnAreBlendedByTheDistanceToTheirNearerEnds) {
  // Row 2 has 10 at both ends, 1 and 4 sites away; column 1 has 40 at both ends, 2 sites away.
  const auto where = [](int x, int y, int) {
    return (y == 2 && (x == 0 || x == 5)) || (x == 1 && (y == 0 || y == 4));
  };
  const Level level = level_of(
      {6, 5}, [](int x, int, int) { return x == 1 ? 40.0F : 10.0F; }, where);
  const ReferenceField field = interpolate_conditions(level);
  EXPECT_NEAR(field[0][level.extent.index(1, 2)], (10.0 / 1.0 + 40.0 / 2.0) / (1.0 / 1.0 + 1.0 / 2.0), 1e-13);
}

} // namespace
} // namespace hdmbench
