// What verify --windows looks at, that a window shows what the whole image would, and that it turns red.

#include "harness/check/verify_windows.hpp"

#include "harness/check/compare.hpp"
#include "harness/check/faults/solution_faults.hpp"
#include "harness/scene/method.hpp"
#include "kernels/data/input_error.hpp"
#include "test/program.hpp"
#include "test/sessions.hpp"
#include "test/textured_scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace hdmbench {
namespace {

using faults::Fault;
using faults::FaultyBackend;
using testing::HasSubstr;

bool contains(const Window& window, int x, int y) {
  return x >= window.x && x < window.x + window.extent.width && y >= window.y &&
         y < window.y + window.extent.height;
}

using test::scalar;

/// Windows of 8 x 8 wherever there are more than 400 sites.
WindowOptions small_windows(std::uint64_t seed = 1) {
  return {
      .session = {.device = {}, .threads = 1}, .plan = {.windows = 7, .side = 8, .seed = seed}, .whole = 400};
}

/// 90 x 70 and five iterations on each level.
Scene small_square() {
  Scene scene = load_scene("square", {.size = Extent{90, 70}});
  scene.schedule.iterations = 5;
  return scene;
}

WindowedComparison examined(const Scene& scene, const Backend& backend, const WindowOptions& options) {
  return verify_windows(scene, scalar(), backend, options, test::silent());
}

TEST(Windows, AreDisjointWithinTheImageAndBeginWithTheCorners) {
  for (const Extent extent : {Extent{90, 70}, Extent{17, 300}, Extent{5, 5}, Extent{1, 9}, Extent{1, 1}}) {
    const Scene scene = test::textured_scene("any", extent, test::Texture::smooth, 3, 1);
    const auto windows = choose_windows(scene.full, {.windows = 8, .side = 8, .seed = 5});
    ASSERT_FALSE(windows.empty());
    for (const auto& [x, y] : {std::pair{0, 0},
                               {extent.width - 1, 0},
                               {0, extent.height - 1},
                               {extent.width - 1, extent.height - 1}}) {
      EXPECT_TRUE(std::ranges::any_of(
          windows, [x = x, y = y](const Window& window) { return contains(window, x, y); }))
          << extent.width << " x " << extent.height;
    }
    std::set<std::size_t> seen;
    std::size_t sites = 0;
    for (const Window& window : windows) {
      sites += window.extent.sites();
      for (int y = window.y; y < window.y + window.extent.height; ++y) {
        for (int x = window.x; x < window.x + window.extent.width; ++x) {
          ASSERT_TRUE(x >= 0 && y >= 0 && x < extent.width && y < extent.height);
          seen.insert(extent.index(x, y));
        }
      }
    }
    EXPECT_EQ(seen.size(), sites) << "no site twice";
  }
}

TEST(Windows, AreTheSameForTheSameSeedAndOneIsOnAnInterface) {
  const Scene scene = small_square();
  const WindowPlan plan{.windows = 8, .side = 8, .seed = 11};
  const auto windows = choose_windows(scene.full, plan);
  ASSERT_EQ(windows.size(), 8U);
  EXPECT_EQ(windows, choose_windows(scene.full, plan));
  EXPECT_NE(windows, choose_windows(scene.full, {.windows = 8, .side = 8, .seed = 12}));
  std::set<float> moduli;
  for (const float modulus : crop(scene.full, windows.at(4)).modulus.values) {
    moduli.insert(modulus);
  }
  EXPECT_EQ(moduli, (std::set{10.0F, 20.0F}));
}

/// The bound that all rests on: a cut is wrong no deeper than the sweeps, and really is wrong at the cut.
TEST(Windows, ACutIsWrongNoDeeperThanTheSweeps) {
  constexpr int sweeps = 5;
  const Scene scene = test::textured_scene("any", {60, 50}, test::Texture::smooth, 7, sweeps);
  const auto swept = [&](const Level& level, const VectorField& begin) {
    const auto session = scalar().open({});
    test::begin(*session, level, begin);
    session->step(sweeps);
    return test::read(*session);
  };
  const VectorField whole = swept(scene.full, scene.start_field());
  const Window inner{.x = 23, .y = 18, .extent = {9, 11}};
  const Window outer = with_influence(inner, sweeps, scene.extent());
  EXPECT_EQ(outer.x, 18);
  EXPECT_EQ(outer.y, 12) << "even, so that colours stay";
  const VectorField part = swept(crop(scene.full, outer), crop(scene.start_field(), outer));
  const VectorField expected = crop(whole, outer);
  EXPECT_GT(compare(expected, part).sites, 0) << "the cut";
  const Window within{.x = inner.x - outer.x, .y = inner.y - outer.y, .extent = inner.extent};
  EXPECT_EQ(compare(crop(expected, within), crop(part, within)).sites, 0);
}

TEST(Windows, ASoundBackendAgreesByEveryMethodThatCanBeCut) {
  for (const char* const method : {"icm", "coloured", "four-coloured", "closed-form"}) {
    Scene scene = small_square();
    if (method == std::string("four-coloured")) {
      scene.full.update = Update::four_coloured;
    } else {
      use_method(scene, find_method(method), 5);
    }
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      const auto comparison = examined(scene, test::find("openmp"), small_windows(seed));
      EXPECT_EQ(comparison.verdict, Verdict::agree) << method << ", seed " << seed;
      ASSERT_EQ(comparison.levels.size(), 8U);
      EXPECT_TRUE(comparison.levels.at(4).whole);
      EXPECT_EQ(comparison.levels.at(4).sites_compared, 16 * 16);
      EXPECT_FALSE(comparison.levels.back().whole);
      EXPECT_EQ(comparison.levels.back().sites_compared, 7 * 64);
    }
  }
}

TEST(Windows, APyramidInOnePieceIsComparedByItsHash) {
  const WindowedComparison sound = examined(small_square(), scalar(), small_windows());
  ASSERT_EQ(sound.pyramids.size(), 2U);
  EXPECT_EQ(sound.verdict, Verdict::agree);
  const auto faults = faults::one_piece_faults();
  const auto fault = std::ranges::find(faults, "projection-weights-swapped", &Fault::name);
  const auto wrong = examined(small_square(), FaultyBackend(scalar(), *fault), small_windows());
  EXPECT_EQ(wrong.verdict, Verdict::disagree);
  EXPECT_EQ(wrong.pyramids.front().same_field, false);
  EXPECT_GT(wrong.pyramids.front().sites_differing, 0);
  for (const WindowedLevel& level : wrong.levels) {
    EXPECT_EQ(level.sites_differing, 0) << "level by level all is well";
  }
}

TEST(Windows, TheLastLevelOnlyInOnePiece) {
  WindowOptions options = small_windows();
  options.last_level = LastLevel::in_one_piece_only;
  const WindowedComparison sound = examined(small_square(), scalar(), options);
  EXPECT_EQ(sound.verdict, Verdict::agree);
  EXPECT_FALSE(sound.levels.back().level_by_level);
  EXPECT_EQ(sound.levels.back().sites_compared, 7 * 64);
  ASSERT_EQ(sound.pyramids.size(), 2U);
  EXPECT_FALSE(sound.pyramids.front().same_field) << "there is nothing to compare it with";
  for (const Fault& fault : faults::one_piece_faults()) {
    if (!fault.in_changed && fault.name != "pyramid-begins-with-its-end") { // of counts and second solutions
      const auto wrong = examined(small_square(), FaultyBackend(scalar(), fault), options);
      EXPECT_EQ(wrong.verdict, Verdict::disagree) << fault.name;
      EXPECT_GT(wrong.levels.back().sites_differing, 0) << fault.name;
      EXPECT_EQ(wrong.levels.at(6).sites_differing, 0) << fault.name;
    }
  }
}

/// One ulp at one site of level 0.
Fault one_ulp_at(int x, int y) {
  return {.name = "one-site", .in_read = [x, y](VectorField& field) {
            if (field.extent == Extent{90, 70}) {
              float& value = field.x[field.extent.index(x, y)];
              value = std::nextafter(value, 1e9F);
            }
          }};
}

TEST(Windows, AFaultInAWindowIsSeenAndOneBesideIsNot) {
  const Scene scene = small_square();
  const auto windows = examined(scene, scalar(), small_windows()).levels.back().windows;
  ASSERT_EQ(windows.size(), 7U);
  for (const Window& window : windows) {
    const int x = window.x + window.extent.width - 1;
    const int y = window.y + window.extent.height / 2;
    const auto seen = examined(scene, FaultyBackend(scalar(), one_ulp_at(x, y)), small_windows());
    EXPECT_EQ(seen.verdict, Verdict::disagree);
    EXPECT_EQ(seen.levels.back().sites_differing, 1);
    ASSERT_TRUE(seen.levels.back().first);
    EXPECT_EQ(seen.levels.back().first->x, x);
    EXPECT_EQ(seen.levels.back().first->y, y);
  }
  int beside = 0; // on the row in the middle
  while (std::ranges::any_of(windows, [&](const Window& window) { return contains(window, beside, 35); })) {
    ++beside;
  }
  const auto unseen = examined(scene, FaultyBackend(scalar(), one_ulp_at(beside, 35)), small_windows());
  EXPECT_EQ(unseen.verdict, Verdict::agree) << "what was compared, and how much that is, says so";
  EXPECT_LT(unseen.levels.back().sites_compared, 90 * 70);
}

TEST(Windows, AFaultOfALevelInBetweenIsSeenThere) {
  const Fault fault{.name = "level-16", .in_read = [](VectorField& field) {
                      if (field.extent == Extent{16, 16}) {
                        field.y[17] = std::nextafter(field.y[17], 1e9F);
                      }
                    }};
  const auto comparison = examined(small_square(), FaultyBackend(scalar(), fault), small_windows());
  EXPECT_EQ(comparison.verdict, Verdict::disagree);
  for (const WindowedLevel& level : comparison.levels) {
    EXPECT_EQ(level.sites_differing, level.extent.width == 16 ? 1 : 0) << "level " << level.level;
  }
}

TEST(Windows, WrongCountsAreSeenOnWholeLevels) {
  const Fault fault{.name = "count", .in_changed = [](std::int64_t changed) { return changed + 1; }};
  const auto comparison = examined(small_square(), FaultyBackend(scalar(), fault), small_windows());
  EXPECT_EQ(comparison.verdict, Verdict::disagree);
  EXPECT_TRUE(comparison.levels.front().count_differs);
  EXPECT_FALSE(comparison.levels.back().count_differs) << "of a window there is none";
}

TEST(Windows, NotANumberIsCounted) {
  const Fault fault{.name = "nan", .in_read = [](VectorField& field) { field.x[0] = std::nanf(""); }};
  const auto comparison =
      examined(small_square(), FaultyBackend(scalar(), fault),
               {.plan = {.windows = 4, .side = 8}, .whole = 0, .last_level = LastLevel::levels_only});
  EXPECT_EQ(comparison.verdict, Verdict::disagree);
  EXPECT_GE(comparison.levels.back().not_finite, 1);
}

TEST(Windows, ADeviceForWhichTheImageIsTooLargeIsSkipped) {
  const Fault fault{.name = "small", .in_level = [](Level& level) {
                      if (level.extent.sites() > 1) { // no piece of it fits either
                        throw TooLarge("no more than one site");
                      }
                    }};
  const auto comparison = examined(small_square(), FaultyBackend(scalar(), fault), small_windows());
  EXPECT_EQ(comparison.verdict, Verdict::skipped);
  EXPECT_THAT(comparison.reason, HasSubstr("no more than one site"));
}

TEST(Windows, WhatCannotBeCutIsRefused) {
  Scene scene = small_square();
  scene.schedule.stop = Stop::still;
  EXPECT_THROW((void)examined(scene, scalar(), small_windows()), InputError);
  scene = small_square();
  scene.full.update = Update::sequential;
  EXPECT_THROW((void)examined(scene, scalar(), small_windows()), InputError);
  for (const char* const method : {"annealing", "multigrid"}) {
    scene = small_square();
    use_method(scene, find_method(method));
    EXPECT_THROW((void)examined(scene, scalar(), small_windows()), InputError) << method;
  }
}

TEST(Windows, AsAUserTypesThem) {
  const test::Outcome outcome = test::expect_run(
      0, "verify square --size 90x70 --windows 6 --whole 20 --quick --seed 3 --backends openmp");
  EXPECT_THAT(
      outcome.output,
      HasSubstr("in one piece, active: 0 sites differ in the windows of the last level; the same field"));
  EXPECT_THAT(outcome.output, testing::ContainsRegex("90 x 70 +10 +[0-9] windows +[0-9,]+ +[0-9.]+ % +0 +-"));
  EXPECT_THAT(outcome.output, HasSubstr("What lies outside the windows was not compared"));
  test::expect_run(2, "verify random --method annealing --windows 6", HasSubstr("annealing"));
}

} // namespace
} // namespace hdmbench
