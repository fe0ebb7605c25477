#include "harness/scene/scene.hpp"

#include "harness/scene/images/images.hpp"
#include "harness/scene/outline.hpp"
#include "test/files.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace hdmbench {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string refusal(const std::string& scene, const SceneOptions& options = {}) {
  return test::refusal([&] { (void)load_scene(scene, options); });
}

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

class SceneFile : public testing::Test {
protected:
  /// What loading `good` says after `from` was replaced by `to`.
  std::string refusal_with(std::string_view from, std::string_view to) {
    std::string text(good);
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return refusal(folder_.write("scene.toml", text).string());
  }

  test::TemporaryFolder folder_;
};

TEST(ShippedScenes, AllButTheBrainLoadAtAnySize) {
  for (const std::string& name : shipped_scenes()) {
    if (name == "brain") {
      continue; // images_test and command_line_test
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
  for (int i = 0; i < 300; ++i) {
    EXPECT_EQ(full.target.x[full.extent.index(0, i)], -50.0F);
    EXPECT_EQ(full.confidence.x[full.extent.index(0, i)], 1.0F);
    EXPECT_EQ(full.confidence.x[full.extent.index(299, i)], 1.0F);
    EXPECT_EQ(full.target.x[full.extent.index(299, i)], 0.0F);
    EXPECT_EQ(full.confidence.y[full.extent.index(i, 0)], 1.0F);
    EXPECT_EQ(full.target.y[full.extent.index(i, 299)], 50.0F);
  }
  EXPECT_EQ(std::ranges::count(full.confidence.x, 1.0F), 600);
  EXPECT_EQ(std::ranges::count(full.confidence.y, 1.0F), 600);
  EXPECT_EQ(full.modulus.values[full.extent.index(150, 150)], 10.0F);
  EXPECT_EQ(full.modulus.values[full.extent.index(20, 150)], 20.0F);
  // A third of the side, within a pixel.
  EXPECT_NEAR(static_cast<double>(std::ranges::count(full.modulus.values, 10.0F)), 1e4, 2.1e2);
}

TEST(ShippedScenes, SchedulesAreTheThesiss) {
  EXPECT_EQ(load_scene("square-modified").schedule.start_level, 5);
  EXPECT_EQ(load_scene("square-modified").schedule.iterations, 500);
  EXPECT_EQ(load_scene("square-single-level").schedule.start_level, 0);
  EXPECT_EQ(load_scene("circular").schedule.iterations, 70);
  EXPECT_EQ(load_scene("circular-radial").schedule.iterations, 50);
}

TEST(ShippedScenes, TheCircularBorderMovesOutwardSideBySide) {
  const Level full = load_scene("circular").full;
  for (int i = 0; i < 300; ++i) {
    EXPECT_EQ(full.target.x[full.extent.index(0, i)], -50.0F);
    EXPECT_EQ(full.target.x[full.extent.index(299, i)], 50.0F);
    EXPECT_EQ(full.target.y[full.extent.index(i, 0)], -50.0F);
    EXPECT_EQ(full.target.y[full.extent.index(i, 299)], 50.0F);
  }
  EXPECT_EQ(std::ranges::count(full.confidence.x, 1.0F), 2 * 300);
  EXPECT_EQ(std::ranges::count(full.confidence.y, 1.0F), 2 * 300);
}

TEST(ShippedScenes, TheRadialExpansionFallsLinearlyFromTheOutlineToTheImageBorder) {
  const Level full = load_scene("circular-radial").full;
  // Along the horizontal axis the outline is at 0.34 * 299 = 101.7 from the centre, the border at 149.5.
  for (int x = 256; x < 300; ++x) {
    const auto i = full.extent.index(x, 150);
    const double radius = x - 149.5;
    EXPECT_NEAR(full.target.x[i], 20.0 * (149.5 - radius) / (149.5 - 101.7), 0.5) << x;
    EXPECT_NEAR(full.target.y[i], 0.0, 0.5) << x;
    EXPECT_EQ(full.confidence.x[i], 1.0F);
    EXPECT_EQ(full.confidence.y[i], 1.0F);
  }
  EXPECT_EQ(full.confidence.x[full.extent.index(150, 150)], 0.0F);
  EXPECT_EQ(full.target.x[full.extent.index(299, 150)], 0.0F);
}

TEST(ShippedScenes, TieRichIsOnItsGrid) {
  const Scene scene = load_scene("tie-rich", {.size = Extent{40, 40}});
  for (const float value : scene.start.value().x) {
    EXPECT_EQ(value, static_cast<float>(0.1 * std::round(value * 10.0)));
  }
  EXPECT_TRUE(std::ranges::all_of(scene.full.modulus.values, [](float m) { return m == 1.0F; }));
}

TEST(LargeScenes, HaveNothingThatIsOnlyLookedAt) {
  EXPECT_TRUE(is_inspected({4096, 4096}));
  EXPECT_TRUE(is_inspected({20000, 800}));
  EXPECT_FALSE(is_inspected({4097, 4096}));
  const Scene scene = load_scene("circular", {.size = Extent{4097, 4096}});
  EXPECT_TRUE(scene.picture.values.empty());
  EXPECT_TRUE(scene.labels.values.empty());
  EXPECT_FALSE(scene.start);
}

/// In a process of its own, which ends with status 0 if loading took no more than `bytes` a site.
void expect_peak_memory(const char* name, double bytes) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need memory of their own";
#endif
  const Extent extent{4099, 4100};
  GTEST_FLAG_SET(death_test_style, "threadsafe"); // a new process: OpenMP's threads do not survive a fork
  const auto peak = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return 1024.0 * static_cast<double>(usage.ru_maxrss);
  };
  EXPECT_EXIT(
      {
        const double before = peak();
        const Scene scene = load_scene(name, {.size = extent});
        const double used = (peak() - before) / static_cast<double>(extent.sites());
        fmt::print(stderr, "{} took {:.1f} bytes a site", name, used);
        std::exit(used <= bytes && scene.extent() == extent ? 0 : 1);
      },
      testing::ExitedWithCode(0), "took");
}

TEST(LargeScenes, Take24BytesASite) {
  expect_peak_memory("square", 24.5);
  expect_peak_memory("circular", 24.5);
}

TEST(LargeScenes, TakeLessThanASolutionWhereTheOutlineIsSearched) {
  expect_peak_memory("circular-radial", 45.0);
}

TEST(Start, NoneIsTheNullFieldAndOneIsSampled) {
  Scene scene = load_scene("square", {.size = Extent{8, 6}});
  EXPECT_FALSE(scene.start);
  EXPECT_EQ(scene.start_field().x, std::vector<float>(48, 0.0F));
  EXPECT_EQ(scene.start_at({4, 2}).y, std::vector<float>(8, 0.0F));
  scene.start.emplace(scene.extent()).y.back() = 3.0F;
  EXPECT_EQ(scene.start_field().y.back(), 3.0F);
  EXPECT_EQ(scene.start_at({4, 2}).y.back(), 3.0F);
}

TEST_F(SceneFile, AGoodFileIsAccepted) {
  const Scene scene = load_scene(folder_.write("mine.toml", good).string());
  EXPECT_EQ(scene.name, "mine");
  EXPECT_EQ(scene.extent(), (Extent{8, 6}));
  EXPECT_EQ(std::ranges::count(scene.full.confidence.x, 1.0F), 6);
  EXPECT_EQ(load_scene(folder_.write("mine.toml", good).string(), {.size = Extent{3, 2}}).extent(),
            (Extent{3, 2}));
}

TEST_F(SceneFile, OnTheBorderOutwardPointsAwayFromTheCentre) {
  std::string text(good);
  text.replace(text.find("\"left\"\ndx = -5.0"), std::string("\"left\"\ndx = -5.0").size(),
               "\"border\"\noutward = 5.0");
  const Level full = load_scene(folder_.write("border.toml", text).string()).full;
  for (int x = 0; x < 8; ++x) {
    const auto i = full.extent.index(x, 0);
    EXPECT_NEAR(std::hypot(full.target.x[i], full.target.y[i]), 5.0, 1e-5);
    EXPECT_NEAR(full.target.x[i] * (0 - 2.5), full.target.y[i] * (x - 3.5), 1e-4);
    EXPECT_LT(full.target.y[i], 0.0F);
  }
  EXPECT_EQ(std::ranges::count(full.confidence.x, 1.0F), 2 * 8 + 2 * 4);
  EXPECT_EQ(std::ranges::count(full.confidence.y, 1.0F), 2 * 8 + 2 * 4);
}

TEST_F(SceneFile, MistakesAreNamedWithTheirLine) {
  EXPECT_THAT(refusal_with("dx = -5.0", "dx = nan"), AllOf(HasSubstr("scene.toml:10"), HasSubstr("dx")));
  EXPECT_THAT(refusal_with("dx = -5.0", "dx = \"five\""), HasSubstr("must be a number"));
  EXPECT_THAT(refusal_with("dx = -5.0", "dx = 1e30"),
              AllOf(HasSubstr("scene.toml:10"), HasSubstr("dx has a displacement of 1e+30 pixels")));
  EXPECT_THAT(refusal_with("dx = -5.0", "dx = -5.0\nconfidence = 1.5"), HasSubstr("within 0 ... 1"));
  EXPECT_THAT(refusal_with("dx = -5.0", "dxx = -5.0"), HasSubstr("dxx is not a key"));
  EXPECT_THAT(refusal_with("dx = -5.0", ""), HasSubstr("give dx, dy or outward"));
  EXPECT_THAT(refusal_with("\"left\"", "\"middle\""), HasSubstr("it must be one of left, right"));
  EXPECT_THAT(refusal_with("modulus = 20.0", "modulus = 0.0"),
              AllOf(HasSubstr(":4"), HasSubstr("must be positive")));
  EXPECT_THAT(refusal_with("modulus = 20.0", "modulus = -3.0"), HasSubstr("must be positive"));
  EXPECT_THAT(refusal_with("modulus = 20.0", "modulus = inf"), HasSubstr("must be finite"));
  EXPECT_THAT(refusal_with("modulus = 20.0", "modulus = 1e-60"), HasSubstr("modulus"));
  EXPECT_THAT(refusal_with("modulus = 20.0", ""), HasSubstr("modulus is missing"));
  EXPECT_THAT(refusal_with("label = 1\nmodulus", "label = 2\nmodulus"),
              AllOf(HasSubstr("label 1"), HasSubstr("x = 0")));
  EXPECT_THAT(refusal_with("size = [8, 6]", "size = [8, 0]"), HasSubstr("whole numbers >= 1"));
  EXPECT_THAT(refusal_with("size = [8, 6]", "size = [8]"), HasSubstr("two numbers"));
  EXPECT_THAT(refusal_with("size = [8, 6]", ""), HasSubstr("size is missing"));
  EXPECT_THAT(refusal_with("size = [8, 6]", "size = [8, 6]\npenalty = 0.0"), HasSubstr("penalty K"));
  EXPECT_THAT(refusal_with("size = [8, 6]", "size = [8, 6]\npoisson = 0.6"), HasSubstr("(-1, 0.5]"));
  EXPECT_THAT(refusal_with("size = [8, 6]", "size = [8, 6]\nsteps = []"),
              HasSubstr("has 0 candidates; give 1 to 16"));
  EXPECT_THAT(refusal_with("size = [8, 6]", "size = [8, 6]\nsteps = \"fast\""), HasSubstr("not a number"));
  EXPECT_THAT(refusal_with("size = [8, 6]", "size = [8, 6"), HasSubstr("scene.toml:"));
  EXPECT_THAT(refusal_with("\"everything\"", "\"rectangle\""), HasSubstr("centre is missing"));
  EXPECT_THAT(
      refusal_with("kind = \"everything\"", "kind = \"ellipse\"\ncentre = [0.5, 0.5]\nsize = [0.1, 0.1]"),
      HasSubstr("unpainted"));
  EXPECT_THAT(refusal_with("\"left\"\ndx", "\"outside\"\noutward"), HasSubstr("no pixel has label 0"));
  EXPECT_THAT(refusal_with("[[shape]]", "[schedule]\niterations = -1\n[[shape]]"), HasSubstr("iterations"));
  EXPECT_THAT(refusal_with("[[shape]]", "[schedule]\nstop = \"never\"\n[[shape]]"),
              HasSubstr("fixed, still, energy"));
  EXPECT_THAT(refusal_with("[[shape]]", "[image]\nlabels = \"a.png\"\n[[shape]]"),
              HasSubstr("exactly one of these"));
}

TEST_F(SceneFile, AnotherEnergyHasMethodsOfItsOwn) {
  const auto with = [&](std::string_view schedule) {
    return load_scene(
        folder_.write("scene.toml", fmt::format("energy = \"elastic\"\n{}{}", good, schedule)).string());
  };
  const Scene usual = with("");
  EXPECT_EQ(usual.energy, EnergyModel::elastic);
  EXPECT_EQ(usual.schedule.method, "full-multigrid");
  const Scene chosen = with("[schedule]\nmethod = \"conjugate-gradients\"\niterations = 5\n");
  EXPECT_EQ(chosen.schedule.method, "conjugate-gradients");
  EXPECT_EQ(chosen.schedule.iterations, 5);
  constexpr std::string_view size = "size = [8, 6]";
  const auto refusal_of = [&](std::string_view schedule) {
    return refusal_with(size, fmt::format("energy = \"elastic\"\n{}\n[schedule]\n{}", size, schedule));
  };
  EXPECT_THAT(refusal_of("method = \"icm\""), HasSubstr("for the elastic energy"));
  EXPECT_THAT(refusal_with(size, "size = [8, 6]\nenergy = \"plastic\""), HasSubstr("one of hdm, elastic"));
}

TEST_F(SceneFile, AnEmptyFileIsToldWhatItMisses) {
  EXPECT_THAT(refusal(folder_.write("empty.toml", "").string()),
              AllOf(HasSubstr("empty.toml:"), HasSubstr("a scene needs exactly one of these")));
}

TEST_F(SceneFile, AnUnknownKeyIsAnsweredWithTheNearestOrAllThatAreUnderstood) {
  const auto above = [&](std::string_view line) {
    return refusal_with("size = [8, 6]", fmt::format("size = [8, 6]\n{}", line));
  };
  EXPECT_THAT(above("penalti = 1.0"), AllOf(HasSubstr("scene.toml:2"), HasSubstr("penalti is not a key"),
                                            HasSubstr("did you mean penalty?")));
  EXPECT_THAT(above("conditions = 1.0"), HasSubstr("did you mean condition?"));
  EXPECT_THAT(above("stepz = 1.0"), HasSubstr("did you mean steps?"));
  EXPECT_THAT(above("colour = 1.0"), HasSubstr("those understood are title, size, penalty, prior_weight"));
  EXPECT_THAT(refusal_with("[[shape]]", "[schedule]\niteration = 1\n[[shape]]"),
              HasSubstr("did you mean iterations?"));
  EXPECT_THAT(refusal_with("[[shape]]", "[image]\ntargets = \"a.nrrd\"\nconfidence = \"b.nrrd\"\n[[shape]]"),
              HasSubstr("exactly one of these"));
}

TEST_F(SceneFile, AKeyWithoutEffectIsRefused) {
  struct Case {
    const char* above; ///< all tables
    const char* schedule;
    const char* condition;
    const char* says;
  };
  for (const Case& one : std::initializer_list<Case>{
           {"energy = \"elastic\"\npenalty = 5", "", "", ":2: penalty has no effect"},
           {"energy = \"elastic\"\nprior_weight = 0.5", "", "", "it belongs to energy = \"hdm\""},
           {"energy = \"elastic\"\nsteps = \"fine\"", "", "", "steps has no effect"},
           {"energy = \"elastic\"", "start_level = 0", "", "start_level has no effect"},
           {"energy = \"elastic\"", "stop = \"still\"", "", "stop has no effect"},
           {"energy = \"elastic\"", "alignment = \"center\"", "", "alignment has no effect"},
           {"robust = 0.5", "", "", "it belongs to energy = \"elastic\""},
           {"", "", "deviation = 2.0", "deviation has no effect"},
           {"", "", "closing = 0.1", "it belongs to where = \"outside\""},
           {"", "epsilon = 1e-3", "", "it belongs to stop = \"energy\""},
           {"", "stop = \"still\"\nepsilon = 1e-3", "", "epsilon has no effect"},
           {"steps = \"fine\"", "method = \"closed-form\"", "", "closed-form does not take steps"},
       }) {
    const std::string text =
        fmt::format("{}\n{}{}\n[schedule]\n{}\n", one.above, good, one.condition, one.schedule);
    EXPECT_THAT(refusal(folder_.write("scene.toml", text).string()), HasSubstr(one.says)) << text;
  }
}

TEST_F(SceneFile, AnObservationHasAConfidenceOrADeviation) {
  const std::string elastic = "energy = \"elastic\"\n";
  const auto refusal_of = [&](std::string_view above, std::string_view condition) {
    return refusal(
        folder_.write("scene.toml", fmt::format("{}{}\n{}{}", elastic, above, good, condition)).string());
  };
  EXPECT_THAT(refusal_of("", "confidence = 0.5\ndeviation = 1.0"),
              HasSubstr("cannot stand beside confidence"));
  EXPECT_THAT(refusal_of("", "deviation = -1.0"), HasSubstr("at least 0 (pixels)"));
  EXPECT_THAT(refusal_of("robust = 0.0", ""), HasSubstr("must be above 0 (pixels)"));
  const std::string text = fmt::format("{}{}deviation = 2.0\n", elastic, good);
  const Scene scene = load_scene(folder_.write("deviation.toml", text).string());
  EXPECT_EQ(scene.full.confidence.x.front(), 0.2F) << "a spring a quarter as stiff as the tissue";
}

TEST_F(SceneFile, AModulusMustHaveAnInverse) {
  for (const char* modulus : {"1e-39", "1e-46", "1e39"}) {
    EXPECT_THAT(refusal_with("20.0", modulus), HasSubstr("a 32-bit float must hold it and its inverse"))
        << modulus;
  }
  EXPECT_EQ(refusal_with("20.0", "3e-39"), "accepted");
  EXPECT_THAT(refusal_with("20.0", "0.0"), HasSubstr("must be positive"));
}

TEST_F(SceneFile, AStartLevelIsOneOfThePyramids) {
  EXPECT_THAT(refusal_with("[[shape]]", "[schedule]\nstart_level = 4\n[[shape]]"),
              HasSubstr("8 x 6 pixels have the levels 0 (full resolution) ... 3"));
  EXPECT_THAT(refusal_with("[[shape]]", "[schedule]\nstart_level = -1\n[[shape]]"),
              HasSubstr("start level -1"));
  EXPECT_EQ(refusal_with("[[shape]]", "[schedule]\nstart_level = 3\n[[shape]]"), "accepted");
  // A file that is right at its own size goes on being so at a smaller one.
  EXPECT_EQ(load_scene("square-modified", {.size = Extent{8, 8}}).schedule.start_level, 3);
}

TEST_F(SceneFile, MissingFilesAreNamed) {
  EXPECT_THAT(refusal("no-such-scene"), AllOf(HasSubstr("no-such-scene"), HasSubstr("square")));
  EXPECT_THAT(refusal(folder_.path().string()), HasSubstr("cannot be read"));
  const auto scene = folder_.write("scene.toml", "[image]\nlabels = \"missing.png\"\n");
  EXPECT_THAT(refusal(scene.string()), HasSubstr(have_images() ? "missing.png" : "without image support"));
}

TEST(Outline, DistancesAndNormalsOfADisc) {
  const Extent extent{81, 81};
  std::vector<bool> inside(extent.sites());
  for (int y = 0; y < 81; ++y) {
    for (int x = 0; x < 81; ++x) {
      inside[extent.index(x, y)] = std::hypot(x - 40, y - 40) <= 20.0;
    }
  }
  const Outline outline = find_outline(inside, extent);
  for (int y = 5; y < 76; ++y) {
    for (int x = 5; x < 76; ++x) {
      const auto i = extent.index(x, y);
      const double radius = std::hypot(x - 40, y - 40);
      EXPECT_NEAR(outline.distance.values[i], radius - 20.0, 1.0);
      EXPECT_EQ(outline.distance.values[i] < 0.0F, static_cast<bool>(inside[i]));
      if (radius > 18.0) {
        const double nx = static_cast<double>(outline.normal.x[i]);
        const double ny = static_cast<double>(outline.normal.y[i]);
        EXPECT_GT((nx * (x - 40) + ny * (y - 40)) / radius, 0.995);
      }
    }
  }
}

TEST(Outline, ClosingFillsNarrowGapsOnly) {
  // A block with a slit 4 pixels wide and a bay 20 pixels wide.
  const Extent extent{80, 40};
  std::vector<bool> inside(extent.sites());
  for (int y = 10; y < 40; ++y) {
    for (int x = 0; x < 80; ++x) {
      const bool slit = x >= 20 && x < 24 && y < 30;
      const bool bay = x >= 40 && x < 60 && y < 30;
      inside[extent.index(x, y)] = !slit && !bay;
    }
  }
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
