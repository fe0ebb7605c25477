// Every backend's whole pyramid in one piece, and its leaving out of what cannot change, against scalar.

#include "harness/check/compare.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/scene.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace hdmbench {
namespace {

using test::pyramid_of;

using Parameter = std::tuple<std::string, Work>;

class WholeSolutionTest : public testing::TestWithParam<Parameter> {
protected:
  void SetUp() override {
    const auto& [name, work] = GetParam();
    try {
      session_ = test::find(name).open({.device = {}, .threads = 2, .work = work, .variant = 0});
    } catch (const DeviceError& error) {
      GTEST_SKIP() << name << " is not there: " << error.what();
    }
    scalar_ = test::scalar().open({});
  }

  void expect_same_solution(const Pyramid& pyramid, const std::string& what) {
    test::expect_same_solution(*scalar_, *session_, pyramid, what);
  }

  void expect_same_steps(const Level& level, const VectorField& start, const std::vector<int>& calls,
                         const std::string& what) {
    test::expect_same_steps(*scalar_, *session_, level, start, calls, what);
  }

  std::unique_ptr<Session> scalar_;
  std::unique_ptr<Session> session_;
};

TEST_P(WholeSolutionTest, SameBitsAtEverySize) {
  std::uint64_t seed = 300;
  for (const Extent extent : {Extent{1, 1}, Extent{1, 7}, Extent{70, 1}, Extent{2, 3}, Extent{64, 8},
                              Extent{65, 33}, Extent{257, 130}}) {
    for (const Alignment alignment : {Alignment::corner, Alignment::center}) {
      const auto problem = test::random_problem(extent, test::Texture::smooth, ++seed);
      expect_same_solution(pyramid_of(problem.level, alignment, 3),
                           fmt::format("{} x {}, seed {}", extent.width, extent.height, seed));
    }
  }
}

TEST_P(WholeSolutionTest, SameBitsForEveryUpdateThatNeedsNoCurvature) {
  for (const Rule rule : {Rule::steps, Rule::annealing}) {
    for (const Update update : test::simultaneous_and_coloured) {
      const auto problem = test::random_problem({90, 41}, test::Texture::smooth, 31, {}, rule, update);
      expect_same_solution(
          pyramid_of(problem.level, Alignment::corner, 4),
          fmt::format("Rule({}), Update({})", static_cast<int>(rule), static_cast<int>(update)));
    }
  }
}

TEST_P(WholeSolutionTest, SameBitsOnTheScenes) {
  for (const char* name : {"square", "circular", "circular-radial", "square-modified"}) {
    const Scene scene = load_scene(name, {.size = Extent{150, 150}});
    const LevelSequence levels(scene);
    const auto pyramid = levels.pyramid();
    ASSERT_TRUE(pyramid) << name;
    expect_same_solution(*pyramid, name);
  }
}

TEST_P(WholeSolutionTest, WhatCannotChangeIsLeftOutWithTheSameBits) {
  std::uint64_t seed = 400;
  for (const Extent extent :
       {Extent{1, 1}, Extent{7, 300}, Extent{300, 7}, Extent{131, 97}, Extent{200, 200}}) {
    for (const test::Texture texture : {test::Texture::smooth, test::Texture::tie_rich}) {
      auto problem = test::random_problem(extent, texture, ++seed);
      expect_same_steps(problem.level, problem.start, {1, 1, 1, 2, 3, 1, 1, 8, 20, 1, 1},
                        fmt::format("{} x {}, seed {}", extent.width, extent.height, seed));
    }
  }
  // A front that runs through a field at rest.
  const Scene scene = load_scene("square", {.size = Extent{200, 200}});
  expect_same_steps(scene.full, scene.start_field(), {1, 1, 1, 1, 5, 1, 1, 20, 1, 1, 60, 1, 1}, "square");
}

TEST_P(WholeSolutionTest, AnotherFieldWakesWhatSlept) {
  const Scene scene = load_scene("square", {.size = Extent{128, 128}});
  expect_same_steps(scene.full, scene.start_field(), {30}, "before");
  VectorField shifted = test::read(*scalar_);
  shifted.x[scene.extent().index(70, 50)] += 3.0F; // far from the front, where larger tiles sleep too
  for (Session* session : {scalar_.get(), session_.get()}) {
    session->write(shifted);
    session->step(5);
  }
  test::expect_same_state(*scalar_, *session_, "woken");
}

TEST_P(WholeSolutionTest, ALevelAfterAPyramidAndAPyramidAfterALevel) {
  const auto problem = test::random_problem({80, 60}, test::Texture::smooth, 51);
  expect_same_solution(pyramid_of(problem.level, Alignment::corner, 3), "first");
  expect_same_steps(problem.level, problem.start, {4}, "level");
  EXPECT_THROW(session_->solve(), std::logic_error);
  expect_same_solution(pyramid_of(problem.level, Alignment::corner, 2), "again");
  EXPECT_THROW(session_->step(1), std::logic_error);
  EXPECT_THROW(session_->write(problem.start), std::logic_error);
}

std::string test_name(const testing::TestParamInfo<Parameter>& info) {
  return test::test_name(std::get<0>(info.param)) + "_" +
         std::string(work_names[static_cast<std::size_t>(std::get<1>(info.param))]);
}

INSTANTIATE_TEST_SUITE_P(Registry, WholeSolutionTest,
                         testing::Combine(testing::ValuesIn(test::backend_names()),
                                          testing::Values(Work::dense, Work::active)),
                         test_name);

} // namespace
} // namespace hdmbench
