// Walls: what slides along one, and springs that pull by direction.

#include "harness/applications/spread.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"
#include "harness/scene/walls.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/laws.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/planner.hpp"
#include "harness/solve/sampled_image.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/finite_elements.hpp"
#include "reference/large_strains.hpp"
#include "test/files.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using test::elastic_level;
using test::Held;
using test::Tissue;
using testing::HasSubstr;

/// Springs of any symmetric, positive semidefinite matrix at every `step`-th site.
void add_springs(Level& level, std::size_t step, std::uint64_t seed) {
  test::Uniform draw(seed);
  const std::size_t axes = level.extent.axes();
  level.springs.assign(axes * (axes + 1) / 2, std::vector<float>(level.extent.sites()));
  for (std::size_t site = 0; site < level.extent.sites(); site += step) {
    const double size = std::pow(10.0, 3.0 * draw() - 1.0);
    for (int rank = 0; rank < 2; ++rank) {
      std::array<double, 3> way{draw() - 0.5, draw() - 0.5, draw() - 0.5};
      for (std::size_t a = 0; a < axes; ++a) {
        for (std::size_t b = a; b < axes; ++b) {
          level.springs[symmetric_entry(axes, a, b)][site] += static_cast<float>(size * way[a] * way[b]);
        }
      }
    }
    for (std::size_t axis = 0; axis < axes; ++axis) {
      level.target[axis][site] += static_cast<float>(2.0 * draw() - 1.0);
    }
  }
}

TEST(Walls, SpringsByDirectionPullAsFiniteElementsSay) {
  for (const auto& [extent, sides] : {std::pair{Extent{33, 28}, std::array{1.0, 1.0, 1.0}},
                                      {Extent{24, 31}, {1.0, 2.5, 1.0}},
                                      {Extent{9, 8, 11}, {1.0, 1.0, 1.0}},
                                      {Extent{8, 12, 7}, {1.5, 1.0, 3.0}}}) {
    Level level = elastic_level(extent, Tissue::noise, Held::scattered, 30.0, 5);
    level.sides = sides;
    add_springs(level, 5, 17);
    const ReferenceField truth =
        solve_finite_elements(elastic_problem(level), ElementRule::of(extent, {0.3}));
    const double error = rmsd(ReferenceField(test::converged(level, 0.3)), truth);
    fmt::print("{}: {:.2g} px\n", extent.text(), error);
    EXPECT_LT(error, 1e-4) << extent.text();
    Level free = level;
    free.springs = {};
    EXPECT_GT(rmsd(ReferenceField(test::converged(free, 0.3)), truth), 0.05) << "springs do not matter";
  }
}

constexpr const char* tissues =
    "energy = \"elastic\"\npoisson = 0.3\n[schedule]\nmethod = \"conjugate-gradients\"\niterations = "
    "60\n[[tissue]]\nlabel = 1\nmodulus = 3.0\ngray = 90\n"
    "[[tissue]]\nlabel = 2\nmodulus = 300.0\ngray = 9\n";

Scene scene_of(const std::string& size, const std::string& more, const SceneOptions& options = {}) {
  const test::TemporaryFolder folder;
  return load_scene(folder.write("scene.toml", "size = " + size + "\n" + tissues + more).string(), options);
}

Solution solved(const Scene& scene) {
  return Solver(test::find("openmp"), {.device = {}, .threads = 2}).solve(scene, test::silent(), {});
}

/// Between two walls a block that is stretched along them does so evenly, whatever it is fixed to beyond.
TEST(Walls, ABlockBetweenTwoStretchesEvenly) {
  for (const bool is_volume : {false, true}) {
    const std::string third = is_volume ? ", 0.5" : "";
    const std::string dz = is_volume ? "dz = 0.0\n" : "";
    const auto scene_with = [&](const std::string& wall) {
      return scene_of(
          is_volume ? "[25, 17, 9]" : "[41, 33]",
          fmt::format(
              "[[shape]]\nkind = \"everything\"\nlabel = 1\n"
              "[[shape]]\nkind = \"{0}\"\nlabel = 2\ncentre = [0.5, 0.0{1}]\nsize = [2.0, 0.5{2}]\n"
              "[[shape]]\nkind = \"{0}\"\nlabel = 2\ncentre = [0.5, 1.0{1}]\nsize = [2.0, 0.5{2}]\n"
              "[[condition]]\nwhere = \"left\"\ndx = -1.0\n[[condition]]\nwhere = \"right\"\ndx = 1.0\n"
              "{3}[[condition]]\nwhere = \"labels\"\nlabels = [2]\n{4}\n",
              is_volume ? "box" : "rectangle", third, is_volume ? ", 2.0" : "",
              is_volume ? "[[condition]]\nwhere = \"front\"\ndz = 0.0\n[[condition]]\nwhere = "
                          "\"back\"\ndz = 0.0\n"
                        : "",
              wall));
    };
    const auto error_of = [&](const Scene& scene) {
      const VectorField field = solved(scene).displacement;
      double most = 0.0;
      const Extent extent = scene.extent();
      for_each_site(extent, [&](int x, int y, int z) {
        const std::size_t at = extent.index(x, y, z);
        if (y > extent.height / 4 + 1 && y < 3 * extent.height / 4 - 1) {
          const double even = 2.0 * x / (extent.width - 1) - 1.0;
          most = std::max({most, std::abs(double{field[0][at]} - even), std::abs(double{field[1][at]})});
        }
      });
      return most;
    };
    const Scene sliding = scene_with("slide = true");
    EXPECT_LT(error_of(sliding), 0.01);
    EXPECT_GT(error_of(scene_with("dx = 0.0\ndy = 0.0\n" + dz)), 0.3)
        << "what is held is not stretched evenly";
    const WallReport walls = walls_under(sliding.full, solved(sliding).displacement);
    EXPECT_EQ(walls.sites, is_volume ? 2U * 25U * 9U : 2U * 41U);
    EXPECT_LT(walls.gave_way, 0.005);
  }
}

/// What is observed of tissue beside a wall pulls it along the wall and not through it: by a point or by a
/// condition, each with a deviation.
TEST(Walls, ObservationsPullNothingThroughThem) {
  const test::TemporaryFolder folder;
  const auto pairs = folder.write("pairs.csv", "20,8.5,0,1,-2,0,2\n").string();
  for (const std::string& observed :
       {fmt::format("[[points]]\nfile = \"{}\"\n", pairs),
        std::string(
            "[[condition]]\nwhere = \"labels\"\nlabels = [3]\ndx = 1.0\ndy = -2.0\ndeviation = 2.0\n")}) {
    const Scene scene = scene_of(
        "[41, 33]", "[[shape]]\nkind = \"everything\"\nlabel = 1\n"
                    "[[shape]]\nkind = \"rectangle\"\nlabel = 3\ncentre = [0.5, 0.3]\nsize = [0.1, 0.4]\n"
                    "[[tissue]]\nlabel = 3\nmodulus = 3.0\n"
                    "[[shape]]\nkind = \"rectangle\"\nlabel = 2\ncentre = [0.5, 0.0]\nsize = [2.0, 0.5]\n"
                    "[[condition]]\nwhere = \"bottom\"\ndx = 0.0\ndy = 0.0\n"
                    "[[condition]]\nwhere = \"labels\"\nlabels = [2]\nslide = true\n" +
                        observed);
    const VectorField field = solved(scene).displacement;
    EXPECT_LT(walls_under(scene.full, field).gave_way, 0.02) << observed;
    const std::size_t beside = scene.extent().index(20, 9);
    EXPECT_GT(scene.full.walls[symmetric_entry(2, 1, 1)][beside], 0.0F) << "it is beside the wall";
    EXPECT_GT(field[0][beside], 0.2F) << "along the wall it follows";
    EXPECT_NEAR(scene.full.target[0][beside], 1.0F, 1e-5);
    Solver solver(test::scalar(), {});
    const Spread spread = spread_of(scene, field, {.draws = 20, .seed = 3}, solver, test::silent());
    EXPECT_LT(spread.deviation[1][beside], 0.1F * spread.deviation[0][beside])
        << "the wall is certain, and so is what is beside it across";
  }
}

/// An observation by direction is one by components where it lies along the axes, on a sampled image, too.
TEST(Walls, OfASampledImageKnowWhatIsObservedByDirection) {
  const Scene by_components = scene_of(
      "[65, 65]", "[[shape]]\nkind = \"everything\"\nlabel = 1\n"
                  "[[shape]]\nkind = \"rectangle\"\nlabel = 2\ncentre = [0.5, 0.0]\nsize = [2.0, 0.48]\n"
                  "[[condition]]\nwhere = \"bottom\"\ndx = 0.0\ndy = 0.0\n"
                  "[[condition]]\nwhere = \"labels\"\nlabels = [1]\ndx = 1.0\ndy = -2.0\ndeviation = 2.0\n"
                  "[[condition]]\nwhere = \"labels\"\nlabels = [2]\nslide = true\n");
  Level by_direction = by_components.full;
  by_direction.springs.assign(3, std::vector<float>(by_direction.extent.sites()));
  for (std::size_t site = 0; site < by_direction.extent.sites(); ++site) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      float& confidence = by_direction.confidence[axis][site];
      by_direction.springs[symmetric_entry(2, axis, axis)][site] =
          static_cast<float>(weight_of_confidence(confidence));
      confidence = is_spring(confidence) ? 0.0F : confidence;
    }
  }
  const auto sampled = [](const Level& full) {
    return sampled_image(full, block_moduli(full.modulus, full.inverse_modulus, {17, 17}),
                         BlockMean::geometric);
  };
  const Level expected = sampled(by_components.full);
  const Level found = sampled(by_direction);
  int sliding = 0;
  for (std::size_t site = 0; site < expected.extent.sites(); ++site) {
    sliding += is_on_wall(found, site) ? 1 : 0;
    for (std::size_t axis = 0; axis < 2 && is_on_wall(found, site); ++axis) {
      EXPECT_NEAR(found.target[axis][site], expected.target[axis][site], 1e-4) << found.extent.place(site);
    }
  }
  EXPECT_GT(sliding, 10);
}

/// A site that samples those beside a wall has what is observed along the wall alone.
TEST(Walls, ObservationsPullNothingThroughThoseOfASampledImage) {
  const Scene scene = scene_of(
      "[65, 65]", "[[shape]]\nkind = \"everything\"\nlabel = 1\n"
                  "[[shape]]\nkind = \"rectangle\"\nlabel = 2\ncentre = [0.5, 0.0]\nsize = [2.0, 0.48]\n"
                  "[[condition]]\nwhere = \"bottom\"\ndx = 0.0\ndy = 0.0\n"
                  "[[condition]]\nwhere = \"labels\"\nlabels = [1]\ndx = 1.0\ndy = -2.0\ndeviation = 2.0\n"
                  "[[condition]]\nwhere = \"labels\"\nlabels = [2]\nslide = true\n");
  const Extent extent{17, 17};
  const Level sampled = sampled_image(
      scene.full, block_moduli(scene.full.modulus, scene.full.inverse_modulus, extent), BlockMean::geometric);
  int sliding = 0;
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    if (sampled.walls[symmetric_entry(2, 1, 1)][site] > 0.0F) {
      ++sliding;
      EXPECT_GT(sampled.target[1][site], -0.01F) << extent.place(site);
      EXPECT_NEAR(sampled.target[0][site], 1.0F, 1e-4) << extent.place(site);
    }
  }
  EXPECT_GE(sliding, 15);
}

/// A disc that its hub turns in a round hole turns as a whole: nothing strains it.
TEST(Walls, ADiscTurnsInARoundHole) {
  for (const bool is_volume : {false, true}) {
    const std::string third = is_volume ? ", 0.5" : "";
    Scene scene = scene_of(
        is_volume ? "[33, 33, 9]" : "[65, 65]",
        fmt::format("[[shape]]\nkind = \"everything\"\nlabel = 2\n[[shape]]\nkind = \"{}\"\nlabel = 1\n"
                    "centre = [0.5, 0.5{}]\nsize = [0.8, 0.8{}]\n{}"
                    "[[condition]]\nwhere = \"labels\"\nlabels = [2]\nslide = true\n",
                    is_volume ? "ellipsoid" : "ellipse", third, is_volume ? ", 1e6" : "",
                    is_volume ? "[[condition]]\nwhere = \"border\"\ndz = 0.0\n" : ""));
    Level& level = scene.full;
    const Extent extent = scene.extent();
    const double middle = 0.5 * (extent.width - 1);
    const auto turned = [&](int x, int y) { return std::array{-0.02 * (y - middle), 0.02 * (x - middle)}; };
    for_each_site(extent, [&](int x, int y, int z) {
      const std::size_t at = extent.index(x, y, z);
      for (std::size_t axis = 0; axis < 2 && std::hypot(x - middle, y - middle) < 0.12 * extent.width;
           ++axis) {
        level.target[axis][at] = static_cast<float>(turned(x, y)[axis]);
        level.confidence[axis][at] = 1.0F;
      }
    });
    const VectorField field = solved(scene).displacement;
    double most = 0.0;
    double largest = 0.0;
    for_each_site(extent, [&](int x, int y, int z) {
      const std::size_t at = extent.index(x, y, z);
      for (std::size_t axis = 0; axis < 2 && level.modulus.values[at] >= void_modulus(level); ++axis) {
        const double wanted = turned(x, y)[axis];
        largest = std::max(largest, std::abs(wanted));
        most = std::max(most, std::abs(double{field[axis][at]} - wanted));
      }
    });
    fmt::print("{}: {:.2g} of {:.2g} px off\n", extent.text(), most, largest);
    EXPECT_LT(most, 0.03 * largest); // a normal from pixels is off by a degree or so
  }
}

/// Prescribes a displacement of some sites beside the middle, to the left by so many pixels.
void move_patch(Level& level, float way) {
  const Extent extent = level.extent;
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t at = extent.index(x, y, z);
    if (std::abs(x - 0.7 * extent.width) < 2 && std::abs(y - 0.5 * extent.height) < 2 &&
        (extent.axes() == 2 || std::abs(z - 0.5 * extent.depth) < 2)) {
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        level.target[axis][at] = axis == 0 ? -way : 0.35F * way;
        level.confidence[axis][at] = 1.0F;
      }
    }
  });
}

Solution by_laws(const Scene& scene, double accuracy) {
  const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
  return solve_by_laws(scene.full, scene.elastic, *session, accuracy, [](const LawStep& /*step*/) {});
}

/// A body of neo-Hookean tissue that slides in an ellipse of the image, or an ellipsoid, some of it moved.
struct SlidingBody {
  Extent extent;
  std::array<double, 3> sides{1.0, 1.0, 1.0};
  double poisson = 0.3;
  double way = 2.0;        ///< pixels
  float of_line = 1.0F;    ///< times as stiff: a line of one pixel through the middle
  bool has_cavity = false; ///< void without a wall
  double wide = 0.4;       ///< half axis along y, of the image
  double of_linear = 0.1;  ///< pixels that the linear law is off, at least
};

Level sliding_body(const SlidingBody& body) {
  const Extent extent = body.extent;
  Level level = test::plain_level(extent, 1.0F);
  level.sides = body.sides;
  level.law_parameter = ScalarField(extent, 0.0F);
  std::vector<bool> beyond(extent.sites());
  const auto away = [&](int x, int y, int z) {
    const auto share = [](int at, int sites, double half) {
      return sites > 1 ? (at - 0.5 * (sites - 1)) / (half * (sites - 1)) : 0.0;
    };
    return std::hypot(share(x, extent.width, 0.42), share(y, extent.height, body.wide),
                      share(z, extent.depth, 0.42));
  };
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t at = extent.index(x, y, z);
    beyond[at] = away(x, y, z) > 1.0;
    if (y == extent.height / 2 + 1) {
      level.modulus.values[at] = body.of_line;
    }
    if (body.has_cavity && std::hypot(x - 0.35 * extent.width, y - 0.5 * extent.height,
                                      z - 0.5 * (extent.depth - 1)) < 0.1 * extent.width) {
      level.modulus.values[at] = 0.0F;
    }
  });
  set_wall(beyond, beyond, body.sides, level);
  move_patch(level, static_cast<float>(body.way));
  const float stiffest = std::ranges::max(level.modulus.values);
  for (std::size_t at = 0; at < extent.sites(); ++at) {
    if (level.modulus.values[at] == 0.0F) {
      level.modulus.values[at] = 0.5F * void_share * stiffest;
      level.law_parameter.values[at] = -1.0F;
    }
  }
  set_inverse_modulus(level);
  return level;
}

/// Expects what solve_by_laws() finds to be as near to Newton's method as is asked.
void expect_newtons_answer(const SlidingBody& body) {
  Level level = sliding_body(body);
  const ElasticModel model{body.poisson};
  const std::vector<double> stiffening(level.law_parameter.values.begin(), level.law_parameter.values.end());
  const ReferenceField truth = solve_large_strains(elastic_problem(level), stiffening, body.poisson, 4);
  const std::vector<std::uint8_t> tissue = test::sites_of_tissue(level);
  const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
  for (const double asked : {0.1, 0.01, 0.001}) {
    int cycles = 0; // on the finest image, of what moves
    Extent image;
    const Solution found = solve_by_laws(level, model, *session, asked, [&](const LawStep& step) {
      cycles = step.extent == image ? cycles + 1 : 1;
      image = step.extent;
    });
    EXPECT_EQ(found.failure + found.beyond_law + found.buckling, "");
    const double error = rmsd(ReferenceField(found.displacement), truth, tissue);
    fmt::print("{}, sides {}, nu {}, {} asked: {:.2g} of it off after {} cycles\n", level.extent.text(),
               body.sides, body.poisson, asked, error / asked, cycles);
    EXPECT_LT(error, asked);
    const bool is_simple = level.extent.axes() == 2 && body.of_line == 1.0F;
    EXPECT_LT(cycles, is_simple ? 20 : 70) << "the cycle knows less of walls than it did";
  }
  level.law_parameter = {};
  EXPECT_GT(rmsd(ReferenceField(test::converged(level, model)), truth, tissue), body.of_linear)
      << "the law does not matter";
}

TEST(Walls, TissueOfLargeStrainsSlidesAsNewtonsMethodSays) {
  for (const SlidingBody& body : {
           SlidingBody{.extent = {41, 37}, .way = 4.0},
           SlidingBody{.extent = {60, 33}, .poisson = 0.0, .way = 3.0},
           SlidingBody{.extent = {37, 44}, .poisson = 0.45},
           SlidingBody{.extent = {41, 24}, .sides = {1.0, 2.5, 1.0}},
           SlidingBody{.extent = {44, 41}, .of_line = 100.0F},
           SlidingBody{.extent = {45, 41}, .has_cavity = true},
           SlidingBody{.extent = {90, 60}, .wide = 0.12, .of_linear = 0.05},
           SlidingBody{.extent = {13, 15, 14}, .way = 1.5},
           SlidingBody{.extent = {14, 15, 13}, .poisson = 0.45, .way = 1.0},
           SlidingBody{.extent = {15, 13, 9}, .sides = {1.0, 1.0, 2.5}, .way = 1.5},
           SlidingBody{.extent = {9, 12, 15}, .sides = {3.0, 1.0, 1.0}, .way = 1.0},
           SlidingBody{.extent = {14, 13, 15}, .way = 1.0, .of_line = 100.0F},
           SlidingBody{.extent = {15, 14, 13}, .way = 0.5, .has_cavity = true, .of_linear = 0.05},
       }) {
    expect_newtons_answer(body);
  }
}

/// What is in no cell of tissue alone carries nothing by laws, and has no balance that Newton's method could
/// find.
TEST(Walls, TissueOnePixelThinBesideAWallIsVoidByLaws) {
  const auto thin_is_void = [](const std::string& law) {
    const Scene scene = scene_of("[41, 33]",
                                 "[[tissue]]\nlabel = 9\nmodulus = 0.0\ngray = 5\n"
                                 "[[shape]]\nkind = \"everything\"\nlabel = 1\n"
                                 "[[shape]]\nkind = \"rectangle\"\nlabel = 2\ncentre = [0.5, 0.0]\n"
                                 "size = [2.0, 0.5]\n"
                                 "[[shape]]\nkind = \"rectangle\"\nlabel = 9\ncentre = [0.5, 0.34375]\n"
                                 "size = [0.3, 0.0625]\n"
                                 "[[condition]]\nwhere = \"left\"\ndx = -1.0\n"
                                 "[[condition]]\nwhere = \"bottom\"\ndy = 0.0\n"
                                 "[[condition]]\nwhere = \"labels\"\nlabels = [2]\nslide = true\n",
                                 {.law = law});
    const Level& level = scene.full;
    EXPECT_LT(level.modulus.values[level.extent.index(20, 11)], void_modulus(level)) << "the cavity";
    EXPECT_GE(level.modulus.values[level.extent.index(20, 14)], void_modulus(level)) << "below it";
    EXPECT_GE(level.modulus.values[level.extent.index(5, 9)], void_modulus(level)) << "beside it";
    return level.modulus.values[level.extent.index(20, 9)] < void_modulus(level);
  };
  EXPECT_TRUE(thin_is_void("neo-hookean"));
  EXPECT_FALSE(thin_is_void("linear"));
}

/// A body with furrows whose surface sinks through an opening of its wall. Cells that are half void turned
/// over, and holes in the walls of coarser images let it out, so that there was no end.
TEST(Walls, TissueOfLargeStrainsSinksThroughAnOpening) {
  for (const bool is_volume : {false, true}) {
    const std::string third = is_volume ? ", 0.5" : "";
    std::string shapes;
    for (int furrow = 0; furrow < 14; ++furrow) {
      const double angle = 2.0 * std::numbers::pi * furrow / 14 + 0.13;
      shapes +=
          fmt::format("[[shape]]\nkind = \"{}\"\nlabel = 2\ncentre = [{}, {}{}]\nsize = [0.03, 0.08{}]\n",
                      is_volume ? "box" : "rectangle", 0.5 + 0.4 * std::cos(angle),
                      0.5 + 0.35 * std::sin(angle), third, is_volume ? ", 1.0" : "");
    }
    const Scene scene = scene_of(
        is_volume ? "[49, 49, 49]" : "[201, 201]",
        fmt::format("[[shape]]\nkind = \"everything\"\nlabel = 2\n[[shape]]\nkind = \"{}\"\nlabel = 1\n"
                    "centre = [0.5, 0.5{}]\nsize = [0.8, 0.7{}]\n{}"
                    "[[condition]]\nwhere = \"labels\"\nlabels = [2]\nslide = true\n"
                    "[[condition]]\nwhere = \"labels\"\nlabels = [2]\ncentre = [0.5, 0.15{}]\n"
                    "size = [0.4, 0.3{}]\ndx = 0.0\ndy = {}\n{}",
                    is_volume ? "ellipsoid" : "ellipse", third, is_volume ? ", 0.75" : "", shapes, third,
                    is_volume ? ", 0.4" : "", is_volume ? 2.0 : 10.0, is_volume ? "dz = 0.0\n" : ""),
        {.law = "neo-hookean"});
    const Solution found = by_laws(scene, 0.02);
    EXPECT_EQ(found.failure + found.beyond_law + found.buckling, "");
    const WallReport walls = walls_under(scene.full, found.displacement);
    fmt::print("{}: {} sites slide, cells keep {:.2g}, walls give way by {:.2g} px\n", scene.extent().text(),
               walls.sites, *found.least_volume, walls.gave_way);
    EXPECT_GT(*found.least_volume, 0.5);
    EXPECT_LT(walls.gave_way, 0.1) << "what a condition prescribes, 10 px at most, is not the wall's";
  }
}

TEST(Walls, TheShippedHeadSlides) {
  if (!std::filesystem::exists("/usr/share/mricron/templates/ch2bet.nii.gz")) {
    GTEST_SKIP() << "no head: install mricron-data";
  }
  const Scene head = load_scene("sliding-head", {.size = Extent{46, 55, 46}});
  const Solution found = solved(head);
  EXPECT_EQ(found.failure + found.beyond_law + found.buckling, "");
  const WallReport walls = walls_under(head.full, found.displacement);
  fmt::print("{} sites slide, cells keep {:.2g}, walls give way by {:.2g} px\n", walls.sites,
             *found.least_volume, walls.gave_way);
  EXPECT_GT(walls.sites, 3000U);
  EXPECT_LT(walls.gave_way, 0.1);
}

/// What an accuracy promises where void and walls are: the estimate counts what transmits something.
TEST(Walls, AnAccuracyIsKept) {
  for (const char* const size : {"[65, 61]", "[97, 120]", "[21, 23, 22]"}) {
    for (const bool slides : {false, true}) {
      const bool is_volume = std::string_view(size).size() > 10;
      const std::string third = is_volume ? ", 0.5" : "";
      const std::string wall = slides      ? "slide = true\n"
                               : is_volume ? "dx = 0\ndy = 0\ndz = 0\n"
                                           : "dx = 0\ndy = 0\n";
      Scene scene = scene_of(
          size,
          fmt::format("[[tissue]]\nlabel = 3\nmodulus = 0.0\ngray = 1\n[[shape]]\nkind = \"everything\"\n"
                      "label = 2\n[[shape]]\nkind = \"{0}\"\nlabel = 1\ncentre = [0.5, 0.5{1}]\nsize = [0.8, "
                      "0.7{2}]\n"
                      "[[shape]]\nkind = \"{0}\"\nlabel = 3\ncentre = [0.45, 0.5{1}]\nsize = [0.25, 0.2{3}]\n"
                      "[[condition]]\nwhere = \"labels\"\nlabels = [2]\n{4}",
                      is_volume ? "ellipsoid" : "ellipse", third, is_volume ? ", 0.8" : "",
                      is_volume ? ", 0.3" : "", wall));
      move_patch(scene.full, 2.0F);
      const Level& level = scene.full;
      const Extent extent = scene.extent();
      const auto plan = [&](double asked) {
        return solve_as_needed(scene, {.accuracy = asked}, test::find("openmp"), {.device = {}, .threads = 2},
                               test::silent());
      };
      const ReferenceField truth =
          solve_finite_elements(elastic_problem(level), ElementRule::of(extent, scene.elastic));
      for (const double asked : {0.1, 0.01, 0.001}) {
        const Plan found = plan(asked);
        const double error = rmsd(ReferenceField(found.solution.displacement), truth);
        fmt::print("{} {}: {}; {:.2g} px off\n", extent.text(), slides ? "slides" : "held", found.outcome,
                   error);
        EXPECT_TRUE(found.met);
        EXPECT_LT(error, asked);
      }
    }
  }
}

TEST(Walls, DoNotTurnAtTheRimOfAnOpeningAndHaveNoBumps) {
  Level level = test::plain_level({31, 31}, 1.0F);
  std::vector<bool> shape(level.extent.sites());
  std::vector<bool> beyond = shape;
  for_each_site(level.extent, [&](int x, int y, int /*z*/) {
    const std::size_t at = level.extent.index(x, y);
    shape[at] = y >= 20 && !(x == 3 && y == 20); // a bump of one pixel
    beyond[at] = shape[at] && (x < 15 || x > 20);
  });
  set_wall(beyond, shape, {1.0, 1.0, 1.0}, level);
  for (const int x : {13, 14, 21, 22}) {
    const std::size_t at = level.extent.index(x, 19);
    EXPECT_GT(level.walls[symmetric_entry(2, 1, 1)][at], 0.0F) << x;
    EXPECT_LT(std::abs(level.walls[symmetric_entry(2, 0, 1)][at]), 2.0F) << x;
  }
  EXPECT_EQ(level.modulus.values[level.extent.index(3, 20)], 0.0F) << "no cell of tissue alone holds it";
  EXPECT_EQ(level.modulus.values[level.extent.index(3, 19)], 1.0F);
  EXPECT_EQ(level.modulus.values[level.extent.index(17, 25)], 1.0F) << "the opening is no void";
}

/// A speck that hangs on a corner or an edge of the tissue around could turn; what a condition knows, and
/// what there is most of, stays.
TEST(Walls, SpecksOnAHingeAreVoid) {
  for (const Extent extent : {Extent{20, 12}, Extent{20, 12, 8}}) {
    Level level = test::plain_level(extent, 1.0F);
    std::vector<bool> solid(extent.sites(), true);
    const auto carve = [&](std::array<int, 3> from, std::array<int, 3> to) {
      for_each_site(extent, [&](int x, int y, int z) {
        if (x >= from[0] && x <= to[0] && y >= from[1] && y <= to[1] &&
            (extent.depth == 1 || (z >= from[2] && z <= to[2]))) {
          solid[extent.index(x, y, z)] = false;
        }
      });
    };
    const int z = extent.depth == 1 ? 0 : 3;
    carve({2, 2, 1}, {8, 8, 6});   // the body
    carve({8, 8, 3}, {10, 10, 5}); // hangs on its corner or edge
    carve({13, 2, 3}, {14, 3, 4}); // is known
    level.confidence[0][extent.index(13, 2, z)] = 1.0F;
    const std::vector<bool> left = with_bumps(solid, level);
    EXPECT_TRUE(left[extent.index(10, 10, z)]) << extent.text();
    EXPECT_TRUE(left[extent.index(9, 8, z)]);
    EXPECT_FALSE(left[extent.index(8, 8, z)]) << "the body's own corner";
    EXPECT_FALSE(left[extent.index(5, 5, z)]);
    EXPECT_FALSE(left[extent.index(14, 3, z)]) << "a condition knows it";
  }
}

TEST(Walls, StifferOnesTakeMoreSteps) {
  const auto steps_with = [](float times) {
    Level level =
        test::body_in_a_wall({129, 129}, [](const auto& at) { return std::hypot(at[0], at[1]) <= 52.0; });
    for (std::vector<float>& entry : level.walls) {
      std::ranges::transform(entry, entry.begin(), [&](float value) { return times * value; });
    }
    for_each_site(level.extent, [&](int x, int y, int /*z*/) {
      const std::size_t at = level.extent.index(x, y);
      for (std::size_t axis = 0; axis < 2 && std::hypot(x - 76, y - 70) < 6.0; ++axis) {
        level.target[axis][at] = axis == 0 ? -6.0F : 2.5F;
        level.confidence[axis][at] = 1.0F;
      }
    });
    set_inverse_modulus(level);
    const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
    ElasticSolver solver(level, 0.3, *session);
    solver.full_multigrid();
    int steps = 0;
    while (++steps < 100 && solver.conjugate_gradients().change > 1e-4) {
    }
    return steps;
  };
  const int usual = steps_with(1.0F);
  const int stiff = steps_with(100.0F);
  fmt::print("{} steps, walls a hundred times as stiff {}\n", usual, stiff);
  EXPECT_LT(usual, 30);
  EXPECT_GT(stiff, 2 * usual);
}

TEST(Walls, EveryBackendHasTheSameBits) {
  for (const Extent extent : {Extent{33, 28}, Extent{9, 8, 10}}) {
    Scene scene;
    use_energy(scene, find_energy("elastic"));
    scene.full = elastic_level(extent, Tissue::noise, Held::scattered, 30.0, 5);
    add_springs(scene.full, 3, 23);
    set_inverse_modulus(scene.full);
    std::optional<VectorField> first;
    for (const Backend* const backend : test::present_backends()) {
      if (backend->has_elastic()) {
        const Solution found = Solver(*backend, {}).solve(scene, test::silent(), {});
        first = first ? first : found.displacement;
        EXPECT_EQ(first->planes, found.displacement.planes) << backend->name();
      }
    }
  }
}

TEST(Walls, AreRefusedWhereTheyHoldNothing) {
  const Scene free = scene_of(
      "[31, 23]", "[[shape]]\nkind = \"everything\"\nlabel = 2\n[[shape]]\nkind = \"rectangle\"\nlabel = 1\n"
                  "centre = [0.5, 0.5]\nsize = [2.0, 0.5]\n"
                  "[[condition]]\nwhere = \"labels\"\nlabels = [2]\nslide = true\n");
  EXPECT_THAT([&] { (void)solved(free); },
              testing::ThrowsMessage<InputError>(HasSubstr("can slide along its walls or turn in them")));
  Scene of_sites = free;
  EXPECT_THAT([&] { use_energy(of_sites, usual_energy()); },
              testing::ThrowsMessage<InputError>(HasSubstr("walls to slide along")));
}

} // namespace
} // namespace hdmbench
