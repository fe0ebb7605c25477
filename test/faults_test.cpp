// The checker is checked: every planted fault must turn verify red, and what is no fault must not.

#include "harness/check/faults/trial.hpp"

#include "test/program.hpp"
#include "test/scenes.hpp"

#include <cctype>
#include <set>

#ifdef HDMBENCH_WITH_GL
#include "harness/check/faults/device_faults.hpp"
#endif

namespace hdmbench {
namespace {

using faults::Expected;
using faults::Planted;
using faults::TrialScene;

nlohmann::json try_on(const Planted& planted, const TrialScene& scene) {
  return faults::try_out(planted, test::scalar(), std::span(&scene, 1), test::silent());
}

/// Those of `hdmbench faults`.
const std::vector<TrialScene>& all_scenes() {
  static const std::vector<TrialScene> scenes = faults::trial_scenes({}, std::nullopt);
  return scenes;
}

/// What is asked of a mistake in a shader is whether verify sees it: of those that both pipelines have, every
/// second one is planted in one and the others in the other. HDMBENCH_ALL_VARIANTS=1: each in both.
std::vector<Planted> tried() {
  std::vector<Planted> list = faults::all_planted(test::scalar());
  if (std::getenv("HDMBENCH_ALL_VARIANTS") != nullptr) {
    return list;
  }
  std::map<std::string, std::set<std::string>> pipelines; // that have a mistake
  for (const Planted& planted : list) {
    if (planted.layer == faults::Layer::shader && planted.expected == Expected::disagree) {
      pipelines[planted.name].insert(planted.backend);
    }
  }
  std::size_t number = 0;
  std::set<std::pair<std::string, std::string>> left_out;
  for (const auto& [name, both] : pipelines) {
    if (both.size() == 2) {
      left_out.emplace(name, ++number % 2 == 0 ? *both.begin() : *both.rbegin());
    }
  }
  std::erase_if(list, [&](const Planted& one) { return left_out.contains({one.name, one.backend}); });
  return list;
}

class PlantedFault : public testing::TestWithParam<Planted> {};

/// In images or in volumes: what is planted in volumes alone is tried on nothing else.
TEST_P(PlantedFault, TurnsVerifyRedUnlessItIsAControl) {
  const bool control = GetParam().expected == Expected::let_through;
  std::set<std::size_t> ran; // the axes of scenes
  std::set<std::size_t> caught;
  std::string reason;
  for (const TrialScene& scene : all_scenes()) {
    const std::size_t axes = scene.scene.extent().axes();
    if (!concerns(GetParam(), scene) || caught.contains(axes)) {
      continue;
    }
    const nlohmann::json row = try_on(GetParam(), scene);
    const nlohmann::json seen = row["scenes"][0];
    EXPECT_EQ(row["not_planted"], "");
    EXPECT_NE(seen["verdict"], "error") << seen["reason"];
    reason = seen["reason"];
    if (row["ran"]) {
      ran.insert(axes);
    }
    if (control) {
      EXPECT_TRUE(row["as_expected"]) << scene.label << ": " << seen["verdict"];
      EXPECT_FALSE(scene.scene.exact && row["ran"] && seen["verdict"] != "agree");
    } else if (row["caught"]) {
      caught.insert(axes);
    }
  }
  if (ran.empty()) {
    GTEST_SKIP() << reason;
  }
  EXPECT_TRUE(control || !caught.empty()) << "caught nowhere";
}

INSTANTIATE_TEST_SUITE_P(Checker, PlantedFault, testing::ValuesIn(tried()), [](const auto& information) {
  std::string name = information.param.backend + "_" + information.param.name;
  std::ranges::replace_if(
      name, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
});

#ifdef HDMBENCH_WITH_GL

TEST(Faults, AreMoreThanAHundred) {
  EXPECT_GE(faults::all_planted(test::scalar()).size(), 120U);
}

TEST(Faults, WhatIsNotThereIsNotPlanted) {
  const std::pair<faults::DeviceFault, const char*> all[] = {
      {{.name = "nothing", .edits = {{"mass of the moon", ""}}}, "\"mass of the moon\" is not in the shader"},
      {{.name = "twice", .edits = {{"real(1)", ""}}}, "more than once"},
      {{.name = "no shader", .shader = "mass of the moon", .edits = {{"x", ""}}}, "no shader"},
      {{.name = "no call", .calls = {{.function = "glDispatchCompute"}}}, "never been made"}};
  for (const auto& [fault, message] : all) {
    const nlohmann::json row = try_on(faults::plant(faults::Pipeline::fragment, fault), all_scenes().front());
    const nlohmann::json seen = row["scenes"][0];
    if (seen["verdict"] == "skipped" && row["not_planted"] == "") {
      GTEST_SKIP() << seen["reason"];
    }
    EXPECT_THAT(row["not_planted"].get<std::string>(), HasSubstr(message)) << fault.name;
    EXPECT_FALSE(row["as_expected"]) << fault.name;
  }
}

#endif

TEST(Faults, AsAUserTypesThem) {
  test::expect_run(0, "faults tie-rich --size 20x12 --faults skipped-sweep,negative-zero",
                   AllOf(HasSubstr("1 of 1 planted faults caught, 1 of 1 controls let through"),
                         testing::ContainsRegex("skipped-sweep +scalar +session +tie-rich +yes")));

  // One level: nothing that is wrong between levels can be seen.
  test::expect_run(1, "faults tie-rich --size 20x12 --faults wrong-alignment,negative-zero --brief",
                   AllOf(HasSubstr("0 of 1 planted faults caught"),
                         testing::ContainsRegex("wrong-alignment +scalar +session +nowhere \\(agree\\) +NO"),
                         testing::Not(HasSubstr("negative-zero"))));

  test::expect_run(2, "faults --faults gremlins", HasSubstr("there is no fault \"gremlins\""));
  EXPECT_THAT(test::hdmbench("faults --list").output, HasSubstr("border-north-west"));
}

} // namespace
} // namespace hdmbench
