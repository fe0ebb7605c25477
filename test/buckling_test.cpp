// Balances that a body with a law of large strains would leave: columns that are pressed beyond Euler's load,
// or stand beyond their own weight. Where nothing tells them to which side to bend a solver finds them
// straight.

#include "harness/solve/methods/laws.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

#include <cmath>
#include <numbers>
#include <tuple>

namespace hdmbench {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::StartsWith;

Level neo_hookean_level(Extent extent) {
  Level level = test::plain_level(extent, 1.0F);
  level.law_parameter = ScalarField(extent, 0.0F);
  return level;
}

void hold(Level& level, int column, float way) {
  const Extent extent = level.extent;
  for_each_site(extent, [&](int x, int y, int z) {
    if (x == column) {
      const std::size_t at = extent.index(x, y, z);
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        level.confidence[axis][at] = 1.0F;
        level.target[axis][at] = axis == 0 ? way : 0.0F;
      }
    }
  });
}

/// A column along x with both ends held, pressed together by a share of its length.
Level pressed(Extent extent, double share) {
  Level level = neo_hookean_level(extent);
  const auto way = static_cast<float>(0.5 * share * (extent.width - 1));
  hold(level, 0, way);
  hold(level, extent.width - 1, -way);
  return level;
}

Solution solved(const Level& level, double poisson = 0.3) {
  const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
  return solve_by_laws(level, poisson, *session, 0.01, [](const LawStep& /*step*/) {});
}

/// Returns the share of its length at which Euler's column with such ends buckles.
double eulers_share(double length, double thickness) {
  return std::numbers::pi * std::numbers::pi / 3.0 * std::pow(thickness / length, 2.0);
}

TEST(Buckling, OfAColumnIsSaidFromEulersLoadOn) {
  for (const Extent extent : {Extent{101, 11}, Extent{161, 9}, Extent{200, 22}, Extent{33, 5, 5},
                              Extent{65, 7, 7}, Extent{81, 9, 30}}) {
    const double share = eulers_share(extent.width - 1, extent.height - 1);
    EXPECT_EQ(solved(pressed(extent, 0.9 * share)).buckling, "") << extent.text();
    const Solution found = solved(pressed(extent, 1.1 * share));
    EXPECT_EQ(found.failure, "") << extent.text();
    const std::string_view said = "the tissue buckles around x = ";
    ASSERT_THAT(found.buckling, StartsWith(std::string(said))) << extent.text();
    const int x = std::stoi(found.buckling.substr(said.size()));
    EXPECT_NEAR(x, extent.width / 2, extent.width / 8) << "not the middle of " << extent.text();
    const Solution beyond = solved(pressed(extent, 1.5 * share));
    EXPECT_NE(beyond.buckling + beyond.gave_way_at, "") << extent.text();
  }
}

/// It stands by itself in void, so that coarser images show it in a few sites. The cells at its border count
/// by half, so that it is a site thicker. Where coarser images do not lie alike on both sides of it, it may
/// have bent.
TEST(Buckling, OfAPartOfTheTissueIsSaidOrItHasBent) {
  for (const Extent extent :
       {Extent{121, 70}, Extent{121, 71}, Extent{161, 161}, Extent{49, 30, 26}, Extent{49, 33, 33}}) {
    const int half = extent.axes() == 3 ? 2 : 5;
    const double share = eulers_share(extent.width - 1, 2.0 * half + 1.0);
    for (const double times : {0.8, 1.2, 1.4}) {
      Level level = pressed(extent, times * share);
      for_each_site(extent, [&](int x, int y, int z) {
        const bool is_column =
            std::abs(y - extent.height / 2) <= half && std::abs(z - extent.depth / 2) <= half;
        if (!is_column) {
          const std::size_t at = extent.index(x, y, z);
          level.modulus.values[at] = 0.5F * void_share;
          level.law_parameter.values[at] = -1.0F;
          for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
            level.confidence[axis][at] = 0.0F;
          }
        }
      });
      set_inverse_modulus(level);
      const Solution found = solved(level);
      EXPECT_EQ(found.failure, "");
      double across = 0.0;
      for (int x = 0; x < extent.width; ++x) { // the column's axis
        const std::size_t at = extent.index(x, extent.height / 2, extent.depth / 2);
        for (std::size_t axis = 1; axis < extent.axes(); ++axis) {
          across = std::max(across, std::abs(double{found.displacement[axis][at]}));
        }
      }
      const bool has_bent = across > 1.0;
      fmt::print("{}, {} of Euler's load: across by {:.2g} px {}\n", extent.text(), times, across,
                 found.buckling);
      EXPECT_EQ(!found.buckling.empty() || has_bent, times > 1.0);
    }
  }
}

/// A film on a softer base, whose far sides slide along rollers, pressed together by a share of its length.
Level pressed_film(Extent extent, int thickness, float contrast, double share) {
  Level level = neo_hookean_level(extent);
  const auto prescribe = [&](std::size_t axis, std::size_t at, double way) {
    level.confidence[axis][at] = 1.0F;
    level.target[axis][at] = static_cast<float>(way);
  };
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t at = extent.index(x, y, z);
    level.modulus.values[at] = y < thickness ? contrast : 1.0F;
    if (x == 0 || x == extent.width - 1) {
      prescribe(0, at, (x == 0 ? 0.5 : -0.5) * share * (extent.width - 1));
    }
    if (y == extent.height - 1) {
      prescribe(1, at, 0.0);
    }
    if (extent.axes() == 3 && z == 0) {
      prescribe(2, at, 0.0);
    }
  });
  set_inverse_modulus(level);
  return level;
}

/// Images of half as many sites show too little of a film to tell. By theory (Allen 1969) it wrinkles where
/// its cells are thin against it, and the base is deep.
TEST(Buckling, OfAThinStiffLayerIsSaid) {
  for (const auto& [extent, thickness, contrast] :
       {std::tuple{Extent{301, 151}, 6, 10.0F}, std::tuple{Extent{241, 101}, 4, 5.0F},
        std::tuple{Extent{97, 41, 10}, 3, 10.0F}}) {
    const double share = 0.25 * std::pow(3.0 / contrast, 2.0 / 3.0);
    for (const double times : {0.75, 1.4}) {
      const Solution found = solved(pressed_film(extent, thickness, contrast, times * share));
      fmt::print("{}, {} of theory's strain: {} {}\n", extent.text(), times, found.failure, found.buckling);
      EXPECT_EQ((found.failure + found.buckling).empty(), times < 1.0) << extent.text();
    }
  }
}

/// A flat film is the same on every sampled image, so that none tells.
TEST(Buckling, OfALayerIsSaidWhereSampledImagesAgree) {
  const test::TemporaryFolder folder;
  const std::string scene = folder.write("film.toml", R"(
title = "A film on a base"
energy = "elastic"
law = "neo-hookean"
size = [310, 189]
tissue = [{ label = 1, name = "base", modulus = 1.0 }, { label = 2, name = "film", modulus = 8.0 }]
shape = [{ kind = "everything", label = 1 },
         { kind = "rectangle", label = 2, centre = [0.5, 0.01], size = [1.1, 0.0212] }]
condition = [{ where = "left", dx = 0.0 }, { where = "right", dx = -60.0 }, { where = "bottom", dy = 0.0 }]
)");
  const std::string run = "run " + scene + " --accuracy 0.1 --output " + folder.path().string();
  test::expect_run(1, run, HasSubstr("the tissue buckles around x = "));
}

/// A column that is held at its foot and stands under its own weight: Greenhill's length.
TEST(Buckling, OfAColumnUnderItsOwnWeightIsSaid) {
  const Extent extent{121, 9};
  constexpr double greenhill = 7.837; // weight over E I / length^2
  const double length = extent.width - 1;
  const double thickness = extent.height - 1;
  const double stiffness = std::pow(thickness, 3.0) / 12.0; // E is 1
  for (const double times : {0.85, 1.15}) {
    Level level = neo_hookean_level(extent);
    hold(level, 0, 0.0F);
    level.force = VectorField(extent);
    const double of_site =
        times * greenhill * stiffness / (length * length) / static_cast<double>(extent.sites());
    std::ranges::fill(level.force[0], static_cast<float>(-of_site));
    const Solution found = solved(level);
    EXPECT_EQ(found.failure, "");
    EXPECT_EQ(found.buckling.empty(), times < 1.0) << times << ": " << found.buckling;
  }
}

/// A load across tells a column to which side: bent it is in a balance that holds.
TEST(Buckling, IsNotSaidOfAColumnThatHasBent) {
  const Extent extent{101, 11};
  Level level = pressed(extent, 1.3 * eulers_share(100.0, 10.0));
  level.force = VectorField(extent);
  std::ranges::fill(level.force[1], 1e-6F);
  const Solution bent = solved(level);
  EXPECT_EQ(bent.failure + doubt_about(bent), "");
  EXPECT_GT(largest_component(bent.displacement), 5.0);
}

/// Rounding tells it to which side, which is said.
TEST(Buckling, OnTheWayIsSaid) {
  for (const double share : {0.1, 0.2}) {
    const Solution found = solved(pressed({101, 11}, share));
    EXPECT_EQ(found.failure + doubt_about(found), "");
    EXPECT_GT(largest_component(found.displacement), 15.0);
    EXPECT_THAT(found.gave_way_at, AnyOf(StartsWith("x = 4"), StartsWith("x = 5")));
  }
}

/// Where there is no end it is said what was seen.
TEST(Buckling, OrATurnIsSaidWhereThereIsNoEnd) {
  EXPECT_THAT(solved(pressed({33, 9, 9}, 0.4)).failure, HasSubstr("gave way around x = 1"));
  EXPECT_THAT(solved(pressed({25, 25, 25}, 0.6)).failure, HasSubstr(" has turned by 1"));
}

} // namespace
} // namespace hdmbench
