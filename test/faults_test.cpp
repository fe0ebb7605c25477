// The checker is checked: every planted fault must turn verify red, and what is no fault must not.

#include "harness/check/faults/session_faults.hpp"
#include "harness/check/faults/trial.hpp"

#include "harness/measure/bench.hpp"
#include "harness/scene/method.hpp"
#include "test/program.hpp"
#include "test/scenes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <functional>

#ifdef HDMBENCH_WITH_GL
#include "harness/check/faults/device_faults.hpp"
#endif

namespace hdmbench {
namespace {

using faults::Expected;
using faults::Fault;
using faults::FaultyBackend;
using faults::Layer;
using faults::Planted;
using faults::Trial;
using faults::TrialScene;

constexpr Extent small{24, 19};
#ifdef HDMBENCH_WITH_GL
constexpr bool has_gl = true;
#else
constexpr bool has_gl = false;
#endif

Scene small_scene(test::Texture texture, Extent extent = small) {
  const bool smooth = texture == test::Texture::smooth;
  const bool exact = texture == test::Texture::dyadic;
  Scene scene = test::textured_scene(smooth  ? "smooth"
                                     : exact ? "dyadic"
                                             : "tie-rich",
                                     extent, texture, 21, 6);
  scene.exact = exact;
  return scene;
}

/// Those of `hdmbench faults`.
const std::vector<TrialScene>& all_scenes() {
  static const std::vector<TrialScene> scenes = faults::trial_scenes({}, std::nullopt);
  return scenes;
}

using test::scalar;

Trial try_on(const Planted& planted, const TrialScene& scene) {
  return faults::try_out(planted, scalar(), std::span(&scene, 1), test::silent());
}

std::vector<Planted> planted(const std::function<bool(const Planted&)>& belongs) {
  std::vector<Planted> some;
  std::ranges::copy_if(faults::all_planted(scalar()), std::back_inserter(some), belongs);
  return some;
}

std::string test_name(const testing::TestParamInfo<Planted>& information) {
  std::string name = information.param.backend + "_" + information.param.name;
  std::ranges::replace_if(
      name, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

class PlantedFault : public testing::TestWithParam<Planted> {};

TEST_P(PlantedFault, TurnsVerifyRed) {
  bool ran = false;
  for (const TrialScene& scene : all_scenes()) {
    if (!concerns(GetParam(), scene)) {
      continue;
    }
    const Trial trial = try_on(GetParam(), scene);
    EXPECT_EQ(trial.not_planted, "");
    EXPECT_EQ(trial.seen.front()->error, "");
    ran = ran || trial.ran();
    if (trial.caught()) {
      return;
    }
    if (!ran) {
      GTEST_SKIP() << trial.seen.front()->reason;
    }
  }
  EXPECT_EQ(GetParam().expected, Expected::either) << "caught nowhere";
}

INSTANTIATE_TEST_SUITE_P(Checker, PlantedFault, testing::ValuesIn(planted([](const Planted& one) {
                           return one.expected != Expected::let_through;
                         })),
                         test_name);

class Control : public testing::TestWithParam<Planted> {};

TEST_P(Control, IsLetThrough) {
  for (const TrialScene& scene : all_scenes()) {
    if (concerns(GetParam(), scene)) {
      const Trial trial = try_on(GetParam(), scene);
      EXPECT_TRUE(trial.as_expected()) << scene.label << ": " << text(*trial.seen.front());
      EXPECT_FALSE(scene.scene.exact && trial.ran() && trial.seen.front()->verdict != Verdict::agree);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Checker, Control, testing::ValuesIn(planted([](const Planted& one) {
                           return one.expected == Expected::let_through;
                         })),
                         test_name);

class FaultInTheField : public testing::TestWithParam<Fault> {};

TEST_P(FaultInTheField, GetsNoSpeedUp) {
  bool caught = false;
  for (const test::Texture texture :
       {test::Texture::smooth, test::Texture::tie_rich, test::Texture::dyadic}) {
    Scene scene = small_scene(texture);
    const FaultyBackend faulty(scalar(), GetParam());
    const Backend* const both[] = {&scalar(), &faulty};
    const auto results = bench(scene, both, {.session = {}, .repeats = 1}, test::silent());
    EXPECT_TRUE(results[0].valid);
    EXPECT_EQ(results[1].valid, results[1].speed_up.has_value());
    caught = caught || !results[1].valid;
  }
  EXPECT_TRUE(caught);
}

std::vector<Fault> faults_in_the_field() {
  std::vector<Fault> some = faults::session_faults();
  // Counts are not bench's affair, each level is uploaded once, and there is no denormal number.
  std::erase_if(some, [](const Fault& fault) {
    return fault.in_changed || fault.method != "icm" || fault.name == "stale-upload" ||
           fault.name == "denormals-flushed";
  });
  return some;
}

INSTANTIATE_TEST_SUITE_P(Checker, FaultInTheField, testing::ValuesIn(faults_in_the_field()),
                         [](const auto& information) { return test::test_name(information.param.name); });

TEST(Faults, AreCountedInDozensAndNamedOnce) {
  std::vector<std::string> names;
  for (const Planted& one : faults::all_planted(scalar())) {
    names.push_back(one.name + " on " + one.backend);
    EXPECT_FALSE(one.what.empty()) << names.back();
  }
  EXPECT_GE(names.size(), has_gl ? 120U : 40U);
  std::ranges::sort(names);
  EXPECT_TRUE(std::ranges::adjacent_find(names) == names.end());
}

TEST(Faults, OnAnySession) {
  for (const auto& backend : test::backends()) {
    for (const Planted& one : faults::all_planted(*backend)) {
      if (one.backend == backend->name() && (one.name == "one-site-one-ulp" || one.name == "sound")) {
        const Trial trial = try_on(one, all_scenes().front());
        EXPECT_TRUE(trial.as_expected()) << one.name << " on " << one.backend;
      }
    }
  }
}

/// What is checked on a scene that cannot show a fault is not checked.
TEST(Faults, ACheckThatCannotFailIsMistrusted) {
  Scene still = small_scene(test::Texture::smooth);
  still.full.confidence = VectorField(still.extent());
  still.start = VectorField(still.extent());
  Scene prescribed = small_scene(test::Texture::smooth);
  prescribed.full.confidence = VectorField(prescribed.extent(), 1.0F);
  prescribed.start = prescribed.full.target;
  prescribed.full.confidence.x[0] = 0.0F;
  prescribed.schedule.start_level = 0;
  const auto sound = planted([](const Planted& one) { return one.name == "sound"; });
  for (const Scene& scene : {still, prescribed}) {
    const Trial trial = try_on(sound.front(), {.label = "dull", .scene = scene});
    EXPECT_EQ(trial.seen.front()->verdict, Verdict::mistrusted);
    EXPECT_FALSE(trial.seen.front()->reason.empty());
    EXPECT_FALSE(trial.ran());
    EXPECT_FALSE(trial.as_expected());
  }
}

#ifdef HDMBENCH_WITH_GL

using faults::DeviceFault;

Trial try_device_fault(const DeviceFault& fault) {
  return try_on(faults::plant(faults::Pipeline::fragment, fault), all_scenes().front());
}

TEST(Faults, WhatIsNotThereIsNotPlanted) {
  const std::pair<DeviceFault, const char*> all[] = {
      {{.name = "nothing", .edits = {{.find = "mass of the moon"}}},
       "\"mass of the moon\" is not in the shader"},
      {{.name = "twice", .edits = {{.find = "real(1)"}}}, "more than once"},
      {{.name = "no shader", .edits = {{.find = "x", .shader = "mass of the moon"}}}, "no shader"},
      {{.name = "no call", .calls = {{.function = "glDispatchCompute"}}}, "never been made"}};
  for (const auto& [fault, message] : all) {
    const Trial trial = try_device_fault(fault);
    if (trial.seen.front()->verdict == Verdict::skipped && trial.not_planted.empty()) {
      GTEST_SKIP() << trial.seen.front()->reason;
    }
    EXPECT_THAT(trial.not_planted, testing::HasSubstr(message)) << fault.name;
    EXPECT_FALSE(trial.as_expected()) << fault.name;
  }
}

TEST(Faults, ATableOfMutationsIsReadAsItSays) {
  const std::string_view table = "# a remark\n\n"
                                 "[control compute | icm | levels | here]\nother | of compute | a | b\n"
                                 "[fragment | annealing | coarse levels | there]\n"
                                 "name | what is wrong | one\\ntwo | \"\" | three | 3\n";
  const std::vector<DeviceFault> list = faults::text_faults(faults::Pipeline::fragment, table);
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0].name, "name");
  EXPECT_EQ(list[0].method, "annealing");
  EXPECT_EQ(list[0].variant, 1U);
  EXPECT_EQ(list[0].expected, Expected::disagree);
  ASSERT_EQ(list[0].edits.size(), 2U);
  EXPECT_EQ(list[0].edits[0].find, "one\ntwo");
  EXPECT_EQ(list[0].edits[0].replace, "");
  EXPECT_EQ(list[0].edits[1].shader, "there");
  for (const char* const damaged : {"name | what | a | b", "[fragment | icm | nowhere | x]",
                                    "[fragment | icm | sweep | x]\nname | what | a"}) {
    EXPECT_THROW((void)faults::text_faults(faults::Pipeline::fragment, damaged), std::invalid_argument);
  }
}

TEST(Faults, ADriverThatRefusesIsNoVerdict) {
  const Trial trial = try_device_fault(
      {.name = "no GLSL", .edits = {{.find = "const int rule = RULE;", .replace = "gibberish"}}});
  if (!trial.ran() && trial.seen.front()->error.empty() && trial.not_planted.empty()) {
    GTEST_SKIP() << trial.seen.front()->reason;
  }
  EXPECT_EQ(trial.not_planted, "");
  EXPECT_THAT(trial.seen.front()->error, testing::HasSubstr("glCompileShader"));
  EXPECT_FALSE(trial.caught());
  EXPECT_FALSE(trial.as_expected());
}

#endif

TEST(Faults, AsAUserTypesThem) {
  test::expect_run(0, "faults tie-rich --size 20x12 --faults skipped-sweep,negative-zero",
                   AllOf(testing::HasSubstr("1 of 1 planted faults caught, 1 of 1 controls let through"),
                         testing::ContainsRegex("skipped-sweep +scalar +session +tie-rich +yes")));

  // One level: nothing that is wrong between levels can be seen.
  test::expect_run(1, "faults tie-rich --size 20x12 --faults wrong-alignment,negative-zero --brief",
                   AllOf(testing::HasSubstr("0 of 1 planted faults caught"),
                         testing::ContainsRegex("wrong-alignment +scalar +session +nowhere \\(agree\\) +NO"),
                         testing::Not(testing::HasSubstr("negative-zero"))));

  test::expect_run(2, "faults --faults gremlins", testing::HasSubstr("there is no fault \"gremlins\""));
  EXPECT_THAT(test::hdmbench("faults --list").output, testing::HasSubstr("border-north-west"));
}

} // namespace
} // namespace hdmbench
