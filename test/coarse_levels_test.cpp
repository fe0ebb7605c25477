// Coarse levels in one dispatch or a dispatch per sweep: how many levels fit, that long dispatches end, and
// that the faster way is taken. That all ways give the same bits is backends_test's affair.

#include "backends/shared/coarse_levels.hpp"
#include "harness/measure/device_row.hpp"
#include "harness/measure/median.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/scene/scene.hpp"
#include "test/bit_cases.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hdmbench {
namespace {

/// `sweeps` on every level.
Pyramid pyramid_of(const Level& full, int sweeps) {
  Pyramid pyramid{.full = &full};
  for (const Extent extent : pyramid_extents(full.extent)) {
    pyramid.levels.insert(pyramid.levels.begin(),
                          {.extent = extent, .sweeps = sweeps, .strengths = full.strengths});
  }
  return pyramid;
}

TEST(CoarseLevelCount, IsOfSmallLevelsButTheLast) {
  const auto count = [](Extent extent) {
    const auto problem = test::random_problem(extent, test::Texture::smooth, 1);
    return coarse_level_count(pyramid_of(problem.level, 1), 64);
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
    return coarse_level_count(pyramid_of(problem.level, 1), 64);
  };
  EXPECT_EQ(count(Rule::annealing, Update::simultaneous), 0U);
  EXPECT_EQ(count(Rule::steps, Update::coloured), 0U);
}

TEST(CoarseLevelCount, KeepsTheDispatchShort) {
  const auto problem = test::random_problem({64, 64}, test::Texture::smooth, 1);
  Pyramid pyramid = pyramid_of(problem.level, 1);
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
};

/// As much as one dispatch may do, on a scene that takes long to rest: rasterizers end long loops early.
TEST_P(CoarseLevelsTest, OfManySweepsAreSweptToTheEnd) {
  const Scene scene = load_scene("square-modified", {.size = Extent{64, 64}});
  for (std::size_t variant = 1; variant < coarse_groups.size(); ++variant) {
    const int group = coarse_groups.at(variant);
    std::vector<test::BitCase> cases;
    for (const int sites_across : {1, 2, 32}) {
      const int sites_each = (sites_across * sites_across + group - 1) / group;
      cases.push_back(
          {.name = fmt::format("{} across, a group of {}", sites_across, group),
           .problem = {.level = scene.full, .start = scene.start_field()},
           .levels = {{.extent = {sites_across, sites_across}, .sweeps = 59'900 / (3 * sites_each + 4) - 2},
                      {.extent = {64, 64}, .sweeps = 1}}});
      ASSERT_EQ(coarse_level_count(cases.back().pyramid(), group), 1U);
    }
    const auto session = backend().open({.device = {}, .variant = variant});
    EXPECT_EQ(test::ExpectedBits(std::move(cases)).differences(*session), "");
  }
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

  const auto session = backend().open({}); // as measured
  test::BitCase one = test::random_bit_case({65, 33}, test::Texture::smooth, 6);
  one.levels = pyramid_of(one.problem.level, 3).levels;
  EXPECT_EQ(test::ExpectedBits({one}).differences(*session), "");
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
