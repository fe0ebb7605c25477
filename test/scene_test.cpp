#include "harness/scene/scene.hpp"

#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"
#include "test/files.hpp"

#include <sys/resource.h>

namespace hdmbench {
namespace {

constexpr std::string_view good = R"(size = [8, 6]
[[tissue]]
label = 1
modulus = 20.0
[[shape]]
kind = "everything"
label = 1
[[condition]]
where = "left"
dx = -5.0
)";

TEST(ShippedScenes, AllButTheBrainLoadAtAnySize) {
  for (const std::string& name : shipped_scenes()) {
    if (name == "brain") {
      continue; // brain_image_test
    }
    for (const Extent extent : {Extent{300, 300}, Extent{64, 64}, Extent{97, 61}}) {
      const Scene scene = load_scene(name, {.size = extent});
      EXPECT_EQ(scene.extent(), extent) << name;
      EXPECT_EQ(scene.picture.values.size(), extent.sites()) << name;
      EXPECT_FALSE(scene.title.empty());
    }
  }
}

TEST(ShippedScenes, TheSquareIsTheThesiss) {
  const Scene scene = load_scene("square");
  const Level& full = scene.full;
  EXPECT_EQ(full.extent, (Extent{300, 300}));
  EXPECT_EQ(scene.schedule.iterations, 50);
  EXPECT_FALSE(scene.schedule.start_level.has_value());
  EXPECT_EQ(full.modulus.values[full.extent.index(150, 150)], 10.0F);
  EXPECT_EQ(full.modulus.values[full.extent.index(20, 150)], 20.0F);
  EXPECT_EQ(load_scene("square-modified").schedule.start_level, 5);
  EXPECT_EQ(load_scene("square-modified").schedule.iterations, 500);
  EXPECT_EQ(load_scene("square-single-level").schedule.start_level, 0);
  EXPECT_EQ(load_scene("circular").schedule.iterations, 70);
  // A third of the side, within a pixel.
  EXPECT_NEAR(static_cast<double>(std::ranges::count(full.modulus.values, 10.0F)), 1e4, 2.1e2);
}

/// A side of the image, by a column or a row of it, whose displacement along one axis is known, and no other
/// site's.
TEST(ShippedScenes, SidesMoveAsInTheThesis) {
  struct Side {
    const char* scene;
    std::size_t axis;
    int column_or_row;
    float target;
  };
  for (const auto& [name, axis, at, target] :
       {Side{"square", 0, 0, -50.0F}, Side{"square", 0, 299, 0.0F}, Side{"square", 1, 0, 0.0F},
        Side{"square", 1, 299, 50.0F}, Side{"circular", 0, 0, -50.0F}, Side{"circular", 0, 299, 50.0F},
        Side{"circular", 1, 0, -50.0F}, Side{"circular", 1, 299, 50.0F}}) {
    const Level full = load_scene(name).full;
    for (int i = 0; i < 300; ++i) {
      const std::size_t site = axis == 0 ? full.extent.index(at, i) : full.extent.index(i, at);
      EXPECT_EQ(full.target[axis][site], target) << name << ", axis " << axis;
      EXPECT_EQ(full.confidence[axis][site], 1.0F) << name << ", axis " << axis;
    }
    EXPECT_EQ(std::ranges::count(full.confidence[axis], 1.0F), 2 * 300) << name << ", axis " << axis;
  }
}

TEST(ShippedScenes, TheRadialExpansionFallsLinearlyFromTheOutlineToTheImageBorder) {
  const Level full = load_scene("circular-radial").full;
  // Along the horizontal axis the outline is at 0.34 * 299 = 101.7 from the centre, the border at 149.5.
  for (int x = 256; x < 300; ++x) {
    const auto i = full.extent.index(x, 150);
    const double radius = x - 149.5;
    EXPECT_NEAR(full.target[0][i], 20.0 * (149.5 - radius) / (149.5 - 101.7), 0.5) << x;
    EXPECT_NEAR(full.target[1][i], 0.0, 0.5) << x;
    EXPECT_EQ(full.confidence[0][i], 1.0F);
    EXPECT_EQ(full.confidence[1][i], 1.0F);
  }
  EXPECT_EQ(full.confidence[0][full.extent.index(150, 150)], 0.0F);
  EXPECT_EQ(full.target[0][full.extent.index(299, 150)], 0.0F);
}

TEST(ShippedScenes, TheMiddleSliceOfTheBallIsTheCircular) {
  const Scene flat = load_scene("circular", {.size = Extent{41, 41}});
  const Scene ball = load_scene("ball", {.size = Extent{41, 41, 41}});
  const auto in_front = std::ptrdiff_t{20} * 41 * 41;
  EXPECT_TRUE(std::equal(flat.labels.values.begin(), flat.labels.values.end(),
                         ball.labels.values.begin() + in_front));
  const Level& full = ball.full;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(std::ranges::count(full.confidence[axis], 1.0F), 2 * 41 * 41) << axis;
    std::array<int, 3> place{7, 8, 9};
    for (const float side : {-10.0F, 10.0F}) {
      place.at(axis) = side < 0.0F ? 0 : 40;
      EXPECT_EQ(full.target[axis][full.extent.index(place[0], place[1], place[2])], side) << axis;
    }
  }
  const Level cube = load_scene("cube").full;
  EXPECT_EQ(cube.extent, (Extent{64, 64, 64}));
  EXPECT_EQ(cube.target[2].back(), 10.0F);
  EXPECT_EQ(cube.confidence[2].front(), 1.0F);
}

/// In a process of its own, which ends with status 0 if loading took no more than 24.5 bytes a site.
TEST(LargeScenes, Take24BytesASite) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need memory of their own";
#endif
  GTEST_FLAG_SET(death_test_style, "threadsafe"); // a new process: OpenMP's threads do not survive a fork
  const auto load = [](const char* name) {
    const auto peak = [] {
      rusage usage{};
      getrusage(RUSAGE_SELF, &usage);
      return 1024.0 * static_cast<double>(usage.ru_maxrss);
    };
    const double before = peak();
    const Scene scene = load_scene(name, {.size = Extent{4099, 4100}});
    const double used = (peak() - before) / static_cast<double>(scene.extent().sites());
    fmt::print(stderr, "took {:.1f} bytes a site", used);
    std::exit(used <= 24.5 && scene.picture.values.empty() && scene.labels.values.empty() ? 0 : 1);
  };
  for (const char* name : {"square", "circular"}) {
    EXPECT_EXIT(load(name), testing::ExitedWithCode(0), "took") << name;
  }
}

TEST(SceneFile, OutwardOnTheBorderPointsAwayFromTheCentre) {
  std::string text(good);
  const test::TemporaryFolder folder;
  text.replace(text.find("\"left\""), text.npos, "\"border\"\noutward = 5.0\n");
  const Level full = load_scene(folder.write("border.toml", text).string()).full;
  for (int x = 0; x < 8; ++x) {
    const auto i = full.extent.index(x, 0);
    EXPECT_NEAR(std::hypot(full.target[0][i], full.target[1][i]), 5.0, 1e-5);
    EXPECT_NEAR(full.target[0][i] * (0 - 2.5), full.target[1][i] * (x - 3.5), 1e-4);
    EXPECT_LT(full.target[1][i], 0.0F);
  }
  EXPECT_EQ(std::ranges::count(full.confidence[0], 1.0F), 2 * 8 + 2 * 4);
  EXPECT_EQ(std::ranges::count(full.confidence[1], 1.0F), 2 * 8 + 2 * 4);
}

TEST(SceneFile, TheElasticEnergyHasMethodsAndDeviations) {
  const test::TemporaryFolder folder;
  const auto with = [&](std::string_view more) {
    return load_scene(
        folder.write("scene.toml", fmt::format("energy = \"elastic\"\n{}{}", good, more)).string());
  };
  const Scene usual = with("");
  EXPECT_EQ(usual.energy->name, "elastic");
  EXPECT_EQ(usual.schedule.method, "full-multigrid");
  const Scene chosen = with("[schedule]\nmethod = \"conjugate-gradients\"\niterations = 5\n");
  EXPECT_EQ(chosen.schedule.method, "conjugate-gradients");
  EXPECT_EQ(chosen.schedule.iterations, 5);
  EXPECT_EQ(with("deviation = 2.0\n").full.confidence[0].front(), 0.2F)
      << "a spring a quarter as stiff as the tissue";
}

TEST(LevelSequence, AVolumeBeginsWithItsStartAndWhatCoarserLevelsChanged) {
  Scene scene = load_scene("cube", {.size = Extent{6, 5, 4}});
  scene.start.emplace(scene.extent());
  const LevelSequence levels(scene);
  VectorField computed = scene.start_at(levels.extent(levels.order()[0]));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::ranges::fill((*scene.start)[axis], static_cast<float>(axis) + 1.0F);
    std::ranges::fill(computed[axis], static_cast<float>(axis) + 1.5F);
  }
  const LevelSequence moved(scene);
  const VectorField begun = moved.begin(moved.order()[1], computed);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(std::ranges::count(begun[axis], static_cast<float>(axis) + 1.5F), std::ssize(begun[axis]));
  }
}

TEST(StepSets, ByNameAndByNumber) {
  EXPECT_EQ(StepSet().text(), "0, -1, -0.1, 1, 0.1");
  EXPECT_EQ(StepSet::parse("default").text(), StepSet().text());
  EXPECT_EQ(StepSet::parse("thesis").text(), "-1, -0.1, 1, 0.1");
  EXPECT_EQ(StepSet::parse("0, -2,+2,1e-2").text(), "0, -2, 2, 0.01");
  EXPECT_EQ(StepSet::parse("0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15").count(), 16);
}

TEST(Outline, DistancesAndNormalsOfADisc) {
  const Extent extent{81, 81};
  std::vector<bool> inside(extent.sites());
  for_each_site(extent,
                [&](int x, int y) { inside[extent.index(x, y)] = std::hypot(x - 40, y - 40) <= 20.0; });
  const Outline outline = find_outline(inside, extent);
  for_each_site(extent, [&](int x, int y) {
    if (std::max(std::abs(x - 40), std::abs(y - 40)) > 35) {
      return;
    }
    const auto i = extent.index(x, y);
    const double radius = std::hypot(x - 40, y - 40);
    EXPECT_NEAR(outline.distance.values[i], radius - 20.0, 1.0);
    EXPECT_EQ(outline.distance.values[i] < 0.0F, static_cast<bool>(inside[i]));
    if (radius > 18.0) {
      EXPECT_GT((double{outline.normal[0][i]} * (x - 40) + double{outline.normal[1][i]} * (y - 40)) / radius,
                0.995);
    }
  });
}

TEST(Outline, DistancesAndNormalsOfABallWhoseSlitIsClosed) {
  const Extent extent{31, 29, 33};
  std::vector<bool> inside(extent.sites());
  const auto radius_at = [](int x, int y, int z) { return std::hypot(x - 15, y - 14, z - 16); };
  for_each_site(extent, [&](int x, int y, int z) {
    const bool is_slit = y == 14 && z > 16;
    inside[extent.index(x, y, z)] = radius_at(x, y, z) <= 10.0 && !is_slit;
  });
  const std::vector<bool> closed = close_gaps(inside, extent, 3.0);
  EXPECT_FALSE(inside[extent.index(15, 14, 20)]);
  EXPECT_TRUE(closed[extent.index(15, 14, 20)]);
  const Outline outline = find_outline(closed, extent);
  for_each_site(extent, [&](int x, int y, int z) {
    const double radius = radius_at(x, y, z);
    const std::array<int, 3> from{x - 15, y - 14, z - 16};
    if (radius > 11.0 && radius < 14.0 && y != 14) {
      double cosine = 0.0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        cosine += from.at(axis) / radius * outline.normal[axis][extent.index(x, y, z)];
      }
      EXPECT_GT(cosine, 0.96) << x << " " << y << " " << z;
      EXPECT_NEAR(outline.distance.values[extent.index(x, y, z)], radius - 10.0, 1.0);
    }
  });
}

TEST(Outline, ClosingFillsNarrowGapsOnly) {
  // A block with a slit 4 pixels wide and a bay 20 pixels wide.
  const Extent extent{80, 40};
  std::vector<bool> inside(extent.sites());
  for_each_site(extent, [&](int x, int y) {
    const bool slit = x >= 20 && x < 24 && y < 30;
    const bool bay = x >= 40 && x < 60 && y < 30;
    inside[extent.index(x, y)] = y >= 10 && !slit && !bay;
  });
  const std::vector<bool> closed = close_gaps(inside, extent, 5.0);
  EXPECT_TRUE(closed[extent.index(22, 20)]);
  EXPECT_FALSE(closed[extent.index(50, 20)]);
  EXPECT_FALSE(closed[extent.index(30, 5)]);
  for (std::size_t i = 0; i < inside.size(); ++i) {
    EXPECT_LE(inside[i], closed[i]);
  }
  EXPECT_EQ(close_gaps(inside, extent, 0.0), inside);
}

} // namespace
} // namespace hdmbench
