// Coarse levels in one dispatch and a dispatch per sweep: the same bits, and the faster one is taken.

#include "backends/shared/coarse_levels.hpp"
#include "harness/check/compare.hpp"
#include "harness/measure/choices.hpp"
#include "harness/measure/median.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/scene/scene.hpp"
#include "test/refusal.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hdmbench {
namespace {

using test::pyramid_of;

const std::vector<Extent> extents{{1, 1}, {1, 1025}, {33, 33}, {90, 7}, {129, 70}};

TEST(CoarseLevelCount, IsOfSmallLevelsButTheLast) {
  const auto count = [](Extent extent) {
    const auto problem = test::random_problem(extent, test::Texture::smooth, 1);
    return coarse_level_count(pyramid_of(problem.level, Alignment::corner, 1), 64);
  };
  EXPECT_EQ(count({1, 1}), 0U);
  EXPECT_EQ(count({32, 32}), 5U); // 1, 2, 4, 8, 16
  EXPECT_EQ(count({33, 33}), 6U);
  EXPECT_EQ(count({300, 300}), 6U);
  EXPECT_EQ(count({2000, 1}), 11U); // to 1024 x 1
}

TEST(CoarseLevelCount, IsNoneWhereASweepMustKnowItsNumber) {
  const auto count = [](Rule rule, Update update) {
    const auto problem = test::random_problem({64, 64}, test::Texture::smooth, 1, {}, rule, update);
    return coarse_level_count(pyramid_of(problem.level, Alignment::corner, 1), 64);
  };
  EXPECT_EQ(count(Rule::annealing, Update::simultaneous), 0U);
  EXPECT_EQ(count(Rule::steps, Update::coloured), 0U);
}

TEST(CoarseLevelCount, KeepsTheDispatchShort) {
  const auto problem = test::random_problem({64, 64}, test::Texture::smooth, 1);
  Pyramid pyramid = pyramid_of(problem.level, Alignment::corner, 1);
  pyramid.levels[3].sweeps = 1'000'000;
  EXPECT_EQ(coarse_level_count(pyramid, 1024), 3U);
  pyramid.levels[3].sweeps = 3000; // 8 x 8 sites
  EXPECT_EQ(coarse_level_count(pyramid, 8), 3U);
  EXPECT_EQ(coarse_level_count(pyramid, 64), 6U);
}

class CoarseLevelsTest : public testing::TestWithParam<std::string> {
protected:
  void SetUp() override {
    try {
      if (backend().variants({}).names.size() < 2) {
        GTEST_SKIP() << GetParam() << " has one way only";
      }
    } catch (const DeviceError& error) {
      GTEST_SKIP() << GetParam() << " is not there: " << error.what();
    }
  }

  [[nodiscard]] const Backend& backend() const { return test::find(GetParam()); }

  [[nodiscard]] std::unique_ptr<Session> open(Work work, std::size_t variant) const {
    return backend().open({.device = {}, .work = work, .variant = variant});
  }

  void expect_same(const Pyramid& pyramid, Session& session, const std::string& what) {
    test::expect_same_solution(*scalar_, session, pyramid, what);
  }

  /// Every way to compute coarse levels that the backend has, worth trying or not.
  template <typename Check>
  void for_each_way(Check&& check) {
    for (const Work work : {Work::dense, Work::active}) {
      const std::vector<std::string> names = backend().variants({}).names;
      for (std::size_t variant = 0; variant < names.size(); ++variant) {
        const std::unique_ptr<Session> session = open(work, variant);
        check(*session, fmt::format("{}, {}", work_names[static_cast<std::size_t>(work)], names[variant]));
      }
    }
  }

  std::unique_ptr<Session> scalar_ = test::scalar().open({});
};

TEST_P(CoarseLevelsTest, HaveTheSameBitsEveryWay) {
  for_each_way([&](Session& session, const std::string& way) {
    std::uint64_t seed = 70;
    for (const Extent extent : extents) {
      for (const Alignment alignment : {Alignment::corner, Alignment::center}) {
        const auto texture = ++seed % 2 == 0 ? test::Texture::smooth : test::Texture::tie_rich;
        const auto problem = test::random_problem(extent, texture, seed);
        expect_same(pyramid_of(problem.level, alignment, 2), session,
                    fmt::format("{}: {} x {}, seed {}", way, extent.width, extent.height, seed));
      }
    }
  });
}

TEST_P(CoarseLevelsTest, ThatComeToRestAndThatDoNot) {
  Scene scene = load_scene("square", {.size = Extent{70, 70}});
  scene.schedule.iterations = 40; // from a null field the coarsest levels rest long before
  const LevelSequence levels(scene);
  const auto pyramid = levels.pyramid();
  ASSERT_TRUE(pyramid);
  ASSERT_GT(coarse_level_count(*pyramid, 8), 0U);
  for_each_way([&](Session& session, const std::string& way) { expect_same(*pyramid, session, way); });
}

/// As much as one dispatch may do, on a scene that takes long to rest: rasterizers end long loops early.
TEST_P(CoarseLevelsTest, OfManySweepsAreSweptToTheEnd) {
  for (std::size_t variant = 1; variant < coarse_groups.size(); ++variant) {
    const int group = coarse_groups.at(variant);
    const auto session = open(Work::dense, variant);
    for (const int sites_across : {1, 2, 32}) {
      Scene scene = load_scene("square-modified", {.size = Extent{64, 64}});
      const int sites_each = (sites_across * sites_across + group - 1) / group;
      const Pyramid pyramid{
          .full = &scene.full,
          .levels = {{.extent = {sites_across, sites_across}, .sweeps = 59'900 / (3 * sites_each + 4) - 2},
                     {.extent = {64, 64}, .sweeps = 1}}};
      ASSERT_EQ(coarse_level_count(pyramid, group), 1U);
      expect_same(pyramid, *session, fmt::format("{} across, a group of {}", sites_across, group));
    }
  }
}

TEST_P(CoarseLevelsTest, WithoutSweepsAndTwiceOfTheSameExtent) {
  const auto problem = test::random_problem({40, 50}, test::Texture::smooth, 5);
  const Pyramid pyramid{.full = &problem.level,
                        .levels = {{.extent = {3, 5}, .sweeps = 0},
                                   {.extent = {3, 5}, .sweeps = 4},
                                   {.extent = {20, 20}, .sweeps = 3},
                                   {.extent = {20, 20}, .sweeps = 2},
                                   {.extent = {40, 50}, .sweeps = 1}}};
  for_each_way([&](Session& session, const std::string& way) { expect_same(pyramid, session, way); });
}

TEST_P(CoarseLevelsTest, OfOtherRulesAreLeftToTheirSweeps) {
  const auto session = open(Work::dense, 1);
  for (const Update update : test::simultaneous_and_coloured) {
    const auto problem =
        test::random_problem({50, 41}, test::Texture::smooth, 31, {}, Rule::annealing, update);
    expect_same(pyramid_of(problem.level, Alignment::corner, 2), *session, "annealing");
  }
  // And from one kind to the other in one session.
  const auto problem = test::random_problem({50, 41}, test::Texture::smooth, 32);
  expect_same(pyramid_of(problem.level, Alignment::corner, 2), *session, "candidates");
}

TEST_P(CoarseLevelsTest, AreComputedTheFastestWay) {
  const std::vector<Choice> choices = backend().choices({});
  ASSERT_EQ(choices.size(), 2U); // and the shape of sweeps
  const Choice& choice = choices.front();
  const Variants variants = backend().variants({});
  ASSERT_EQ(choice.options.size(), variants.worth_trying);
  for (std::size_t i = 0; i < choice.options.size(); ++i) {
    EXPECT_EQ(choice.options[i].name, variants.names[i]);
    ASSERT_EQ(choice.options[i].seconds.size(), 5U);
    EXPECT_GE(median(choice.options[i].seconds), median(choice.options[choice.chosen].seconds));
  }
  const std::vector<Choice> again = backend().choices({});
  EXPECT_EQ(again.front().options.front().seconds, choice.options.front().seconds) << "measured again";
  EXPECT_THAT(describe(choice), testing::HasSubstr(variants.names.front()));
  EXPECT_EQ(to_json_row(choice).at("chosen"), choice.options[choice.chosen].name);

  const auto problem = test::random_problem({65, 33}, test::Texture::smooth, 6);
  const auto session = backend().open({});
  expect_same(pyramid_of(problem.level, Alignment::corner, 3), *session, "as measured");
}

TEST_P(CoarseLevelsTest, AVariantThatTheDeviceCannotDoIsRefused) {
  const auto problem = test::random_problem({65, 33}, test::Texture::smooth, 6);
  const Pyramid pyramid = pyramid_of(problem.level, Alignment::corner, 3);
  EXPECT_THAT(test::refusal<DeviceError>([&] { open(Work::dense, 7)->load(pyramid); }),
              testing::HasSubstr("no variant 7"));
}

TEST(Variants, ThereAreNoneOnTheCpu) {
  EXPECT_TRUE(test::scalar().variants({}).names.empty());
  EXPECT_TRUE(test::scalar().choices({}).empty());
}

INSTANTIATE_TEST_SUITE_P(Registry, CoarseLevelsTest, testing::Values("gl-compute", "vulkan-compute"),
                         [](const auto& information) {
                           return information.param == "gl-compute" ? "gl" : "vulkan";
                         });

} // namespace
} // namespace hdmbench
