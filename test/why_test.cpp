// Which rewrite of the arithmetic made a backend's bits: 32 rewrites of the texts are planted, one line each,
// and verify has to name kind and line; what is no rewrite must not be named one.

#include "backends/cpu/elastic_serial.hpp"
#include "harness/check/faults/faulty_backend.hpp"
#include "harness/check/verify.hpp"
#include "harness/check/why.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "test/scenes.hpp"

#ifdef HDMBENCH_WITH_GL
#include "harness/check/faults/device_faults.hpp"
#endif

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>
#include <set>
#include <tuple>

namespace hdmbench {
namespace {

using rewritten::Kind;
using rewritten::Rewrite;

/// Lines that a scene's solution has operations on, and what can be rewritten there.
std::vector<Rewrite> rewritable_lines(const Scene& scene) {
  std::set<Rewrite> seen;
  const rewritten::Replay replay({}, &seen);
  if (scene.energy->is_of_cells()) {
    ElasticSerial<rewritten::real> session;
    Progress silent(false);
    (void)solve_elastic(scene, session, silent);
  } else {
    LevelSequence levels(scene);
    const int coarsest = levels.order().front();
    const Level& level = levels.sample(coarsest);
    const VectorField begin = levels.begin(coarsest, {});
    for_each_site(level.extent, [&](int x, int y, int z) {
      (void)proofs_of(level).replayed_answer(level, begin, 0, x, y, z);
    });
  }
  std::set<Rewrite> lines;
  for (const Rewrite& one : seen) {
    lines.insert({.kind = one.kind, .place = rewritten::Place{one.place->file, one.place->line}});
  }
  return {lines.begin(), lines.end()};
}

/// What verify says of a backend with these rewrites; empty where no bit differs.
std::string why_of(const Scene& scene, const std::vector<Rewrite>& rewrites) {
  const auto backend = faults::make_rewritten(rewrites);
  for (const Comparison& comparison : test::verified(scene, *backend)) {
    if (comparison.mode == Mode::resync) {
      EXPECT_EQ(comparison.why.empty(), comparison.sites_differing == 0);
      return comparison.why;
    }
  }
  return {};
}

/// A scene, and how many rewrites are planted in its arithmetic.
struct PlantedIn {
  Scene scene;
  std::size_t rewrites;
};

std::vector<PlantedIn> scenes_with_rewrites() {
  std::vector<PlantedIn> all;
  for (const auto& [name, method, extent, rewrites] :
       {std::tuple{"random", "closed-form", Extent{24, 17}, 10},
        {"ball", "closed-form", Extent{7, 6, 5}, 8},
        {"random", "full-multigrid", Extent{21, 14}, 10},
        {"ball", "full-multigrid", Extent{5, 6, 5}, 4}}) {
    PlantedIn& one = all.emplace_back(load_scene(name, {.size = extent}), rewrites);
    use_method(one.scene, find_method(method), 2);
  }
  return all;
}

TEST(Why, NamesTheLineOfARewrite) {
  std::size_t planted = 0;
  std::size_t named = 0;
  std::string missed;
  for (const auto& [scene, rewrites] : scenes_with_rewrites()) {
    const std::vector<Rewrite> lines = rewritable_lines(scene);
    std::size_t differing = 0;
    // Through the list in a stride that meets all kinds; a rewrite that no bit shows is none.
    for (std::size_t i = 0; i < lines.size() && differing < rewrites; ++i) {
      const Rewrite& one = lines[i * 37 % lines.size()];
      const std::string why = why_of(scene, {one});
      if (why.empty()) {
        continue;
      }
      ++differing;
      const bool is_named =
          why.find(text_of(one)) != std::string::npos && why.find("that makes all") != std::string::npos;
      named += is_named ? 1 : 0;
      missed += is_named ? "" : fmt::format("{}: {}\n  said: {}\n", scene.name, text_of(one), why);
    }
    EXPECT_EQ(differing, rewrites) << scene.name;
    planted += differing;
  }
  std::printf("%zu of %zu planted rewrites are named with their line\n%s", named, planted, missed.c_str());
  EXPECT_GE(15 * named, 14 * planted) << missed;
}

#ifdef HDMBENCH_WITH_GL
/// What a real driver makes of a shader in which a line is another one.
TEST(Why, NamesTheLineThatADriverWasGivenOtherwise) {
  struct Edit {
    const char* line;
    const char* other;
    const char* why;
  };
  const Edit edits[] = {
      {"real difference = ratio * (dt - ds) - (du - dt);", "real difference = (ratio * (dt - ds) - du) + dt;",
       "terms are added in another order in hdm/energy.inc, line 15: that makes all of"},
      {"real difference = ratio * (dt - ds) - (du - dt);",
       "real difference = (ratio * dt - ratio * ds) - (du - dt);",
       "a product with a sum is made of its terms in hdm/energy.inc, line 15: that makes all of"},
      {"real difference = ratio * (dt - ds) - (du - dt);", "real difference = ratio * (dt - ds) - (dt - du);",
       "none of "}, // a mistake
  };
  const Scene scene = scenes_with_rewrites().front().scene;
  for (const auto& [line, other, why] : edits) {
    const faults::Planted planted = faults::plant(
        faults::Pipeline::compute,
        {.name = other, .what = why, .method = scene.schedule.method, .edits = {{line, other}}});
    const auto backend = planted.make();
    std::string said;
    for (const Comparison& comparison : test::verified(scene, *backend)) {
      if (comparison.verdict == Verdict::skipped && comparison.was_not_opened) {
        GTEST_SKIP() << comparison.reason;
      }
      said += comparison.mode == Mode::resync ? comparison.why : "";
    }
    EXPECT_THAT(said, testing::HasSubstr(why)) << other;
  }
}
#endif

/// A component of the last site is off by a pixel after each sweep, or the elastic energy has other cells and
/// other inverse blocks: no arithmetic does that.
TEST(Why, AMistakeIsNoRewrite) {
  for (const auto& [scene, rewrites] : scenes_with_rewrites()) {
    const faults::FaultyBackend backend(
        test::scalar(), {.name = "one-off",
                         .in_sweep = [](VectorField& after, const VectorField&) { after[0].back() += 1.0F; },
                         .in_hierarchy =
                             [](ElasticHierarchy& hierarchy) {
                               for (std::vector<float>& moments : hierarchy.levels.back().moments) {
                                 std::ranges::reverse(moments);
                               }
                               for (std::vector<float>& response : hierarchy.levels.front().response) {
                                 std::ranges::transform(response, response.begin(),
                                                        [](float value) { return 0.75F * value; });
                               }
                             }});
    std::string said;
    for (const Comparison& comparison : test::verified(scene, backend)) {
      said += comparison.mode == Mode::resync ? comparison.why : "";
    }
    EXPECT_THAT(said, testing::StartsWith("none of ")) << scene.name;
  }
}

/// What was to be written is gone when one asks why.
TEST(Why, AFieldThatDoesNotArriveIsNoRewrite) {
  for (const auto& [scene, rewrites] : scenes_with_rewrites()) {
    const faults::FaultyBackend backend(
        test::scalar(), {.name = "not-written", .in_elastic_step = [](const MethodStep& step, bool) {
                           return step.kind != MethodStep::Kind::write;
                         }});
    for (const Comparison& comparison : test::verified(scene, backend)) {
      EXPECT_THAT(comparison.why, testing::Not(testing::HasSubstr("that makes all"))) << scene.name;
      EXPECT_TRUE(!scene.energy->is_of_cells() || comparison.sites_differing > 0) << scene.name;
    }
  }
}

/// Where a site sees others that have moved already, nobody can compute it alone.
TEST(Why, NothingIsSaidOfSequentialUpdates) {
  Scene scene = scenes_with_rewrites().front().scene;
  scene.full.update = Update::sequential;
  const faults::FaultyBackend backend(
      test::scalar(), {.name = "last-site",
                       .in_sweep = [](VectorField& after, const VectorField&) { after[0].back() += 1.0F; }});
  bool differs = false;
  for (const Comparison& comparison : test::verified(scene, backend)) {
    differs = differs || comparison.sites_differing > 0;
    EXPECT_EQ(comparison.why, "");
  }
  EXPECT_TRUE(differs);
}

/// Two liberties at the same time.
TEST(Why, NamesSeveralLines) {
  const Scene scene = scenes_with_rewrites().front().scene;
  std::vector<Rewrite> two;
  for (const Rewrite& one : rewritable_lines(scene)) {
    if (one.kind == Kind::fused_first && two.size() < 2 && !why_of(scene, {one}).empty()) {
      two.push_back(one);
    }
  }
  ASSERT_EQ(two.size(), 2);
  const std::string why = why_of(scene, two);
  EXPECT_THAT(why, testing::AllOf(testing::HasSubstr(text_of(two[0])), testing::HasSubstr(text_of(two[1])),
                                  testing::HasSubstr("that makes all")));
}

TEST(Why, FusingEverywhereIsNamed) {
  for (const auto& [scene, rewrites] : scenes_with_rewrites()) {
    EXPECT_THAT(why_of(scene, {rewritten::all_fused.front()}),
                testing::HasSubstr("every product is fused into the sum that follows"))
        << scene.name;
  }
}

} // namespace
} // namespace hdmbench
