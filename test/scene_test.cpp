#include "harness/scene/scene.hpp"

#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/scene_content.hpp"
#include "harness/scene/sites.hpp"
#include "test/files.hpp"

#include <sys/resource.h>

#include <set>

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

/// Golden hashes hold what images are.
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

/// Golden hashes hold outlines and closed gaps of images: circular-radial and the brain have both.
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
  EXPECT_EQ(close_gaps(inside, extent, 0.0), inside);
  EXPECT_EQ(close_gaps(closed, extent, 3.0), closed) << "nothing is left to fill";
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

class ShippedTissues : public ImageFiles {};

/// SynthSeg's own list of labels, without its parcellation of the cortex.
TEST_F(ShippedTissues, HaveASourceEach) {
  const auto labels_of = [](const std::string& name) {
    std::set<int> labels;
    const toml::table root = parse_toml(tissues_text(name), name);
    for (const toml::node& node : *root["tissue"].as_array()) {
      const toml::table& tissue = *node.as_table();
      const int label = tissue["label"].value<int>().value();
      EXPECT_TRUE(labels.insert(label).second) << label;
      EXPECT_GT(tissue["source"].value_or(std::string()).size(), 10U) << name << ' ' << label;
      EXPECT_GT(tissue["name"].value_or(std::string()).size(), 3U) << name << ' ' << label;
      const double modulus = tissue["modulus"].value<double>().value();
      EXPECT_TRUE(modulus >= 1e-4 && modulus <= 1.0) << name << ' ' << label << ": " << modulus << " MPa";
    }
    return labels;
  };
  EXPECT_EQ(labels_of("brain"), (std::set{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(labels_of("synthseg"),
            (std::set{0,  2,  3,  4,  5,  7,  8,  10, 11, 12, 13, 14, 15, 16, 17, 18, 24,
                      26, 28, 41, 42, 43, 44, 46, 47, 49, 50, 51, 52, 53, 54, 58, 60}));
}

TEST_F(ShippedTissues, AreThereByNameUnlessThereIsAFile) {
  const std::string labels =
      write_nrrd("labels.nrrd", "short", "3 2 2", "0 2 3 41 42 24 0 0 2 2 3 3").string();
  const Scene scene = load_scene(labels, {.tissues = "synthseg"});
  EXPECT_EQ(scene.full.modulus.values[1], 0.001895F);
  EXPECT_THAT(scene.idle, IsEmpty()) << "nobody has every label";
  const std::string others =
      write_nrrd("others.nrrd", "short", "3 2 2", "0 2 3 41 1001 77 77 0 2 2 3 3").string();
  expect_refusal([&] { (void)load_scene(others, {.tissues = "synthseg"}); },
                 "the labels 77, 1001 (3 pixels) have no [[tissue]]");
  expect_refusal([&] { (void)load_scene(labels, {.tissues = "synthetic"}); },
                 "shipped are brain and synthseg");
}

} // namespace
} // namespace hdmbench
