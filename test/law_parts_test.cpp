// Parts of a level that laws of large strains are solved on by themselves.

#include "harness/judge/truths.hpp"
#include "harness/solve/level_parts.hpp"
#include "harness/solve/methods/laws.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/large_strains.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

#include <cmath>

namespace hdmbench {
namespace {

using testing::HasSubstr;

/// A body in surroundings that conditions hold: the middle of an image or a volume, of radius `radius` of its
/// shorter sides, in which `press` moves the site in the middle along x, pixels. The surroundings are sheared
/// and have `modulus` beyond the box around the body; the body's is 1, with void of the least modulus there
/// is in one place.
Level body_in_surroundings(Extent extent, float modulus, double press) {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent)};
  level.law_parameter = ScalarField(extent, 0.0F);
  const std::array<int, 3> sides = extent.sides();
  const double radius = 0.3 * std::min({sides[0], sides[1], extent.axes() == 3 ? sides[2] : sides[0]});
  for_each_site(extent, [&](int x, int y, int z) {
    const std::array<double, 3> way{x - 0.5 * (sides[0] - 1), y - 0.45 * (sides[1] - 1),
                                    z - 0.55 * (sides[2] - 1)};
    const std::size_t site = extent.index(x, y, z);
    const double far = std::hypot(way[0], way[1], extent.axes() == 3 ? way[2] : 0.0);
    const bool is_held = far > radius;
    const bool is_middle = far < 1.5;
    const auto is_beyond = [&](double along) { return std::abs(along) > radius + 2.0; };
    const bool is_void = far > 0.5 * radius && far < 0.8 * radius && std::abs(way[1]) < 1.5 && way[0] > 0.0;
    level.modulus.values[site] = std::ranges::any_of(std::span(way).first(extent.axes()), is_beyond) ? modulus
                                 : is_void ? 0.5F * void_share * modulus
                                           : 1.0F;
    level.law_parameter.values[site] = is_void ? -1.0F : 0.0F;
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      level.confidence[axis][site] = is_held || is_middle ? 1.0F : 0.0F;
      const double shear = axis == 0 ? 0.1 * way[1] : 0.0;
      level.target[axis][site] = static_cast<float>(is_held ? shear : is_middle && axis == 0 ? press : 0.0);
    }
  });
  set_inverse_modulus(level);
  return level;
}

Solution solved(const Level& level, double accuracy, const std::function<void(const LawStep&)>& say = {}) {
  const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
  return solve_by_laws(
      level, 0.3, *session, accuracy, say ? say : [](const LawStep& /*step*/) {});
}

TEST(LawParts, WhatIsHeldAroundIsNotSolved) {
  for (const Extent extent : {Extent{41, 38}, Extent{19, 22, 20}}) {
    const Level level = body_in_surroundings(extent, 1.0F, 1.5);
    const ReferenceField truth =
        solve_large_strains(elastic_problem(level),
                            {level.law_parameter.values.begin(), level.law_parameter.values.end()}, 0.3, 2);
    const Solution found = solved(level, 1e-4);
    EXPECT_EQ(found.failure + found.beyond_law + found.buckling, "");
    ASSERT_TRUE(found.part);
    EXPECT_LT(found.part->sites(), extent.sites() / 2);
    EXPECT_LT(rmsd(ReferenceField(found.displacement), truth), 1e-4) << extent.text();
    std::size_t held = 0;
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      for (std::size_t axis = 0; axis < extent.axes() && level.confidence[axis][site] >= 1.0F; ++axis) {
        EXPECT_EQ(found.displacement[axis][site], level.target[axis][site]);
        ++held;
      }
    }
    EXPECT_GT(held, extent.sites() / 2);
  }
}

/// Void is a share of the stiffest modulus: it stays void where that is cut off.
TEST(LawParts, SurroundingsThatAreHeldMayBeAsStiffAsTheyLike) {
  for (const Extent extent : {Extent{41, 38}, Extent{19, 22, 20}}) {
    const Solution soft = solved(body_in_surroundings(extent, 1.0F, 1.5), 1e-4);
    const Solution stiff = solved(body_in_surroundings(extent, 0x1p20F, 1.5), 1e-4);
    EXPECT_EQ(soft.displacement.planes, stiff.displacement.planes) << extent.text();
  }
}

/// A message names the place in the whole image.
TEST(LawParts, ACellThatIsTurnedOverIsSaidWhereItIs) {
  const Level level = body_in_surroundings({61, 58}, 1.0F, -19.0);
  const Solution found = solved(level, 0.01);
  ASSERT_TRUE(found.part);
  EXPECT_THAT(found.beyond_law, HasSubstr("the cell at x = 2")); // beside what was moved, at 30
}

TEST(LawParts, APartThatNothingHoldsIsSaidWhereItIs) {
  Level level = body_in_surroundings({61, 58}, 1.0F, 1.5);
  for_each_site(level.extent, [&](int x, int y) {
    const int far = std::max(std::abs(x - 22), std::abs(y - 30));
    const bool is_around = far == 3 || far == 4;
    float& modulus = level.modulus.values[level.extent.index(x, y)];
    modulus = is_around ? 0.5F * void_share : modulus;
  });
  set_inverse_modulus(level);
  try {
    (void)solved(level, 0.01);
    FAIL() << "a part that nothing holds was solved";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("x = 20"));
  }
}

/// Where the coarser image leaves cells turned over, the parts around them are solved before the image.
TEST(LawParts, AFewCellsThatAreTurnedOverDoNotCostStepsOfTheImage) {
  const Extent extent{49, 45, 41};
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent)};
  level.law_parameter = ScalarField(extent, 0.0F);
  for_each_site(extent, [&](int x, int y, int z) { // an opening of the top, through which the body sinks
    const std::size_t site = extent.index(x, y, z);
    const double far = std::hypot(x - 23.0, y - 21.0) / 11.0;
    const bool is_held = x == 0 || y == 0 || z == 0 || x == 48 || y == 44 || z >= 33;
    level.modulus.values[site] = (x / 3 + y / 3 + z / 3) % 2 == 0 ? 1.0F : 4.0F;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      level.confidence[axis][site] = is_held ? 1.0F : 0.0F;
    }
    level.target[2][site] = z >= 33 && far < 1.0 ? static_cast<float>(-9.0 * (1.0 - far * far)) : 0.0F;
  });
  set_inverse_modulus(level);
  int cycles = 0; // on the finest image
  Extent image;
  const Solution found = solved(level, 0.01, [&](const LawStep& step) {
    cycles = step.extent == image ? cycles + 1 : 1;
    image = step.extent;
  });
  EXPECT_EQ(found.failure, "");

  EXPECT_LT(cycles, 12);
}

} // namespace
} // namespace hdmbench
