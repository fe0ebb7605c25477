// The methods of the elastic energy against finite elements by a direct factorisation in double.

#include "harness/judge/truths.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "reference/finite_elements.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using test::elastic_level;
using test::Held;
using test::Tissue;

ReferenceField truth_of(const Level& level, const ElasticModel& model) {
  return solve_finite_elements(elastic_problem(level), ElementRule::of(level.extent, model));
}

/// Sites from the truth after full multigrid and at most `steps` of conjugate gradients.
double solved(const Level& level, const ElasticModel& model, int steps) {
  const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
  ElasticSolver solver(level, model, *session);
  solver.full_multigrid();
  for (int i = 0; i < steps && !solver.conjugate_gradients().ended; ++i) {
  }
  const VectorField found = solver.displacement();
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    for (std::size_t i = 0; i < level.extent.sites(); ++i) { // conditions stand to the bit
      EXPECT_TRUE(level.confidence[axis][i] < 1.0F || found[axis][i] == level.target[axis][i]) << i;
    }
  }
  return rmsd(ReferenceField(found), truth_of(level, model));
}

TEST(ElasticSolve, OddAndThinImages) {
  for (const Extent extent : {Extent{2, 2}, {5, 4}, {33, 64}, {2, 60}, {61, 3}}) {
    const Level level = elastic_level(extent, Tissue::noise, Held::border, 30.0, 8);
    EXPECT_LT(solved(level, 0.3, 30), 1e-4) << extent.width << " x " << extent.height;
  }
}

/// Coarse cells that a long body fills by a corner only would let waves grow, which a small Poisson's ratio
/// shows.
TEST(ElasticSolve, LongVolumes) {
  for (const Extent extent : {Extent{5, 5, 100}, {6, 100, 6}}) {
    for (const Held held : test::all_held) {
      const Level level = elastic_level(extent, Tissue::inclusion, held, 2.0, 8);
      EXPECT_LT(solved(level, 0.0, 20), 1e-4) << extent.text() << ", held " << static_cast<int>(held);
    }
  }
}

/// Targets reach 5 pixels. Thin layers of very different moduli take longest: their coarse modulus is a mean.
TEST(ElasticSolve, ConvergesWhateverTheTissue) {
  for (const Tissue tissue : test::all_tissues) {
    for (const Held held : test::all_held) {
      for (const double contrast : {1.0, 10.0, 1000.0}) {
        for (const double poisson : {0.0, 0.3, 0.49}) {
          const std::string what =
              fmt::format("tissue {}, held {}, contrast {}, Poisson's ratio {}", static_cast<int>(tissue),
                          static_cast<int>(held), contrast, poisson);
          const int steps = contrast == 1.0            ? (held == Held::springs ? 12 : 6)
                            : contrast == 10.0         ? 10
                            : tissue == Tissue::layers ? 70
                                                       : 30;
          EXPECT_LT(solved(elastic_level({49, 38}, tissue, held, contrast, 5), poisson, steps), 1e-4) << what;
          // A force in the stiffest tissue is rounded by this, and a spring in the softest one carries it.
          const double rounding = held == Held::springs ? 5.0 * 0x1p-23 * contrast : 0.0;
          for (const Integration integration : {Integration::full, Integration::selective_reduced}) {
            EXPECT_LT(
                solved(elastic_level({9, 8, 11}, tissue, held, contrast, 8), {poisson, integration}, 250),
                1e-4 + rounding)
                << what << ", integration " << static_cast<int>(integration);
          }
        }
      }
    }
  }
}

/// A soft cube whose faces are moved along their normals, with stiff voxels where `is_stiff` says.
Level pressed_cube(int side, const std::function<bool(int, int, int)>& is_stiff) {
  Level level = elastic_level({side, side, side}, Tissue::inclusion, Held::border, 1.0, 3);
  for_each_site(level.extent, [&](int x, int y, int z) {
    level.modulus.values[level.extent.index(x, y, z)] = is_stiff(x, y, z) ? 1000.0F : 1.0F;
  });
  return level;
}

/// A line, a sheet or a dot of one voxel that lies between the sites of the next level is in the middle of
/// its cells, which are alike on both sides and yet not of one modulus: there waves grew.
TEST(ElasticSolve, CyclesConvergeWhereStiffLinesLieBetweenTheSitesOfCoarseLevels) {
  const auto odd = [](int at) { return at % 4 == 3; };
  const std::vector<std::pair<const char*, std::function<bool(int, int, int)>>> makes{
      {"a line along z", [](int x, int y, int) { return x == 7 && y == 7; }},
      {"a line along x", [](int, int y, int z) { return y == 3 && z == 5; }},
      {"lines", [&](int x, int y, int) { return odd(x) && odd(y); }},
      {"sheets", [&](int, int y, int) { return odd(y); }},
      {"dots", [&](int x, int y, int z) { return odd(x) && odd(y) && odd(z); }}};
  for (const auto& [name, is_stiff] : makes) {
    for (const double poisson : {0.3, 0.49}) {
      const Level level = pressed_cube(11, is_stiff);
      const std::string what = fmt::format("{}, Poisson's ratio {}", name, poisson);
      const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
      ElasticSolver cycles(level, poisson, *session);
      cycles.full_multigrid();
      double least = cycles.cycle().change;
      for (int i = 0; i < 120; ++i) {
        const double change = cycles.cycle().change;
        ASSERT_LT(change, 1.5 * least + 1e-6) << what << ", cycle " << i;
        least = std::min(least, change);
      }
      EXPECT_LT(solved(level, poisson, 120), 1e-3) << what;
    }
  }
}

TEST(ElasticSolve, CyclesThatGrowAreSeen) {
  CyclesError error(1.0, 1.0, 1e-6);
  for (const double moved : {1.0, 0.01, 0.02, 0.01, 1e-7, 5e-6}) { // as they do on their way, and in rounding
    error.add(moved);
    EXPECT_FALSE(error.grow()) << moved;
  }
  error.add(1e-3);
  EXPECT_TRUE(error.grow());
  error.add(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(error.grow());
}

/// Springs so weak that steps do not see how the body moves as a whole; where they are all, at rest is where
/// they balance.
TEST(ElasticSolve, ABodyThatOnlyWeakSpringsHoldIsBroughtToBalance) {
  const auto held_by = [](const std::function<int(int, int, int)>& components) {
    Level level = elastic_level({9, 8, 7}, Tissue::inclusion, Held::supports, 4.0, 5);
    level.confidence = VectorField(level.extent);
    for_each_site(level.extent, [&](int x, int y, int z) {
      const std::size_t at = level.extent.index(x, y, z);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if ((components(x, y, z) >> axis & 1) != 0) {
          level.target[axis][at] =
              static_cast<float>(0.3 * x - 0.2 * y + 0.1 * z * static_cast<double>(axis));
          level.confidence[axis][at] = confidence_of_deviation(x == 0 ? 3000.0 : 1000.0);
        }
      }
    });
    return level;
  };
  const std::vector<std::pair<std::size_t, Level>> levels{
      {6, held_by([](int x, int, int) { return x == 0 || x == 8 ? 7 : 0; })},
      {6, held_by([](int x, int y, int z) { return (x + 3 * y + 5 * z) % 11 == 0 ? 7 : 0; })},
      {5,
       [&] { // x is known for good at one site
         Level level = held_by([](int x, int y, int) { return x == 0 || y == 7 ? 7 : 0; });
         level.confidence[0][level.extent.index(3, 3, 3)] = 1.0F;
         return level;
       }()},
      {1, [&] { // and all but the turn about one edge
         Level level = held_by([](int x, int, int) { return x == 8 ? 7 : 0; });
         for (int z = 0; z < 7; ++z) {
           for (std::size_t axis = 0; axis < 3; ++axis) {
             level.confidence[axis][level.extent.index(0, 0, z)] = 1.0F;
           }
         }
         return level;
       }()}};
  for (const auto& [motions, of_cubes] : levels) {
    for (const std::array<double, 3>& sides : {std::array{1.0, 1.0, 1.0}, {1.0, 2.0, 1.5}}) {
      Level level = of_cubes;
      level.sides = sides;
      EXPECT_EQ(free_motions(level).size(), motions);
      const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
      ElasticSolver solver(level, 0.3, *session);
      solver.full_multigrid();
      for (int i = 0; i < 12; ++i) {
        (void)solver.conjugate_gradients();
      }
      solver.settle(level);
      EXPECT_LT(rmsd(ReferenceField(solver.displacement()), truth_of(level, 0.3)), 2e-3)
          << motions << " motions, sides " << sides[1];
    }
  }
}

std::string refusal(const Level& level) {
  return test::refusal([&] { require_held(level); });
}

void hold(Level& level, int x, int y, bool in_x, bool in_y) {
  const std::size_t at = level.extent.index(x, y);
  level.confidence[0][at] = in_x ? 1.0F : level.confidence[0][at];
  level.confidence[1][at] = in_y ? 0.5F : level.confidence[1][at]; // a spring holds, too
}

TEST(ElasticConditions, AFreeSheetIsAnErrorThatSaysWhere) {
  Level level = elastic_level({12, 9}, Tissue::inclusion, Held::border, 1.0, 1);
  EXPECT_EQ(refusal(level), "accepted");
  level.confidence = VectorField(level.extent);
  EXPECT_THAT(refusal(level), HasSubstr("all 12 x 9 sites can move in x"));
  hold(level, 3, 4, true, false);
  EXPECT_THAT(refusal(level), HasSubstr("can move in y"));
  hold(level, 5, 7, false, true);
  EXPECT_THAT(refusal(level), HasSubstr("all 12 x 9 sites can turn about x = 5, y = 4"));
  hold(level, 5, 1, false, true);
  EXPECT_THAT(refusal(level), HasSubstr("can turn about"));
  hold(level, 6, 1, false, true);
  EXPECT_EQ(refusal(level), "accepted") << "y in two columns";
  level.confidence = VectorField(level.extent);
  hold(level, 3, 4, true, true);
  hold(level, 7, 5, true, false);
  EXPECT_EQ(refusal(level), "accepted") << "x in two rows";
  EXPECT_THAT(refusal(elastic_level({1, 9}, Tissue::noise, Held::border, 1.0, 1)),
              HasSubstr("at least 2 x 2"));
}

/// A frame that is held, void inside, and a block of 4 x 3 pixels in it.
Level island(float void_modulus) {
  const Extent extent{20, 18};
  Level level = test::plain_level(extent, void_modulus);
  for_each_site(extent, [&](int x, int y) {
    const bool frame = x < 2 || y < 2 || x >= 18 || y >= 16;
    const bool block = x >= 8 && x < 12 && y >= 7 && y < 10;
    level.modulus.values[extent.index(x, y)] = frame || block ? 10.0F : void_modulus;
    hold(level, x, y, x == 0 || y == 0, x == 0 || y == 0);
  });
  return level;
}

TEST(ElasticConditions, AFreePartIsAnErrorThatSaysWhere) {
  EXPECT_EQ(refusal(island(1e-4F)), "accepted") << "soft is not void";
  Level level = island(1e-7F);
  EXPECT_THAT(refusal(level), testing::AllOf(HasSubstr("12 pixels at x = 8 ... 11, y = 7 ... 9"),
                                             HasSubstr("it can move in x")));
  hold(level, 5, 5, true, true);
  EXPECT_THAT(refusal(level), HasSubstr("it can move in x")) << "a condition in the void holds nothing";
  hold(level, 9, 8, true, false);
  EXPECT_THAT(refusal(level), HasSubstr("it can move in y"));
  hold(level, 9, 8, false, true);
  EXPECT_THAT(refusal(level), HasSubstr("it can turn about x = 9, y = 8"));
  hold(level, 11, 9, false, true);
  EXPECT_EQ(refusal(level), "accepted");
  Level joined = island(1e-7F);
  for (int x = 2; x < 6; ++x) {
    joined.modulus.values[joined.extent.index(x, 8)] = 10.0F;
  }
  EXPECT_NE(refusal(joined), "accepted") << "two void pixels between";
  joined.modulus.values[joined.extent.index(6, 8)] = 10.0F;
  EXPECT_EQ(refusal(joined), "accepted") << "one";
  Level diagonal = island(1e-7F);
  for (int x = 2; x < 7; ++x) {
    diagonal.modulus.values[diagonal.extent.index(x, 11)] = 10.0F;
  }
  EXPECT_EQ(refusal(diagonal), "accepted") << "one, at a corner of both";
  diagonal.modulus.values[diagonal.extent.index(6, 11)] = 1e-7F;
  EXPECT_NE(refusal(diagonal), "accepted") << "two";
}

} // namespace
} // namespace hdmbench
