// The exact tier: the proof that nothing is rounded and what it refuses, and scenes for which it holds. What
// a compiler's freedom does to these scenes is in free_backend_test.

#include "harness/check/certificate.hpp"

#include "test/files.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace hdmbench {
namespace {

using test::Texture;
using testing::HasSubstr;

/// What the first sweep that is not exact says; empty where all are.
std::string inexact(const Scene& scene) {
  std::string text;
  test::for_each_sweep(scene, [&](const Level& level, const VectorField& before, int number) {
    if (text.empty()) {
      const auto found = first_inexact(level, before, number);
      text = found ? found->text() : "";
    }
  });
  return text;
}

/// The energy changes of all candidates in x, whether or not they round.
std::vector<float> changes_in_x(const Level& level, const VectorField& field, int x, int y) {
  const HdmInFloat::Site site = gather<HdmInFloat>(level, field, x, y);
  const HdmInFloat::Prior prior = HdmInFloat::prior_of(site);
  std::vector<float> changes;
  for (const float step : level.steps.values()) {
    changes.push_back(HdmInFloat::energy_change(step, prior.gradient_x, prior.curvature_x,
                                                site.target_x - site.dx.centre,
                                                site.penalty * site.confidence_x));
  }
  return changes;
}

class ExactScene : public testing::TestWithParam<std::string> {
protected:
  const Scene scene_ = load_scene(GetParam());
};

TEST_P(ExactScene, IsDeclaredAndProvenAtEverySweep) {
  EXPECT_TRUE(scene_.exact);
  EXPECT_EQ(inexact(scene_), "");
}

TEST_P(ExactScene, IsProvenAtOtherSizesAndForEveryOrderOfSites) {
  for (const Extent extent : {Extent{1, 1}, Extent{2, 8}, Extent{32, 16}, Extent{16, 16}}) {
    for (const Update update : test::simultaneous_and_coloured) {
      Scene scene = load_scene(GetParam(), {.size = extent});
      scene.full.update = update;
      EXPECT_TRUE(scene.exact);
      EXPECT_EQ(inexact(scene), "") << extent.width << " x " << extent.height;
    }
  }
}

// What makes the scene worth comparing: it moves where materials meet, and candidates tie for the lowest
// energy.
TEST_P(ExactScene, MovesAtContrastsAndHasTies) {
  int contrasts = 0;
  int ties = 0;
  const VectorField last =
      test::for_each_sweep(scene_, [&](const Level& level, const VectorField& before, int number) {
        const VectorField after = test::swept(level, before, number);
        for (int y = 0; y < level.extent.height; ++y) {
          for (int x = 1; x < level.extent.width; ++x) {
            const auto i = level.extent.index(x, y);
            const bool contrast = level.modulus.values[i] != level.modulus.values[i - 1];
            contrasts += contrast && after.x[i] != before.x[i] ? 1 : 0;
            const auto changes = changes_in_x(level, before, x, y);
            ties += std::ranges::count(changes, std::ranges::min(changes)) > 1 ? 1 : 0;
          }
        }
      });
  EXPECT_GT(contrasts, 500);
  EXPECT_GT(ties, 500);

  Scene reversed = scene_;
  std::vector<float> steps(scene_.full.steps.values().begin(), scene_.full.steps.values().end());
  std::ranges::reverse(steps);
  reversed.full.steps = StepSet(steps);
  const VectorField other = test::for_each_sweep(reversed, [](const Level&, const VectorField&, int) {});
  EXPECT_NE(last.x, other.x) << "nothing here depends on the order of candidates";
}

INSTANTIATE_TEST_SUITE_P(Shipped, ExactScene,
                         testing::Values("exact-textures", "exact-pyramid", "exact-square"),
                         [](const auto& parameter) { return parameter.param.substr(6); });

TEST(ExactScenes, AreAmongTheShippedOnes) {
  EXPECT_EQ(test::exact_scenes().size(), 3U);
}

TEST(ExactScenes, HaveEveryRatioOfModuliAndPartialConfidences) {
  const Level full = load_scene("exact-textures").full;
  std::set<float> ratios;
  for (int y = 0; y < full.extent.height; ++y) {
    for (int x = 1; x < full.extent.width; ++x) {
      const auto i = full.extent.index(x, y);
      ratios.insert(full.modulus.values[i] / full.modulus.values[i - 1]);
    }
  }
  EXPECT_EQ(ratios, (std::set<float>{0.0625F, 0.125F, 0.25F, 0.5F, 1.0F, 2.0F, 4.0F, 8.0F, 16.0F}));
  EXPECT_EQ(std::set(full.confidence.x.begin(), full.confidence.x.end()),
            (std::set<float>{0.0F, 0.25F, 0.5F, 1.0F}));
}

// Two interpolations, of weights 1/4 and 3/4 along both axes, each four binary digits.
TEST(ExactScenes, InterpolationBetweenLevelsDoesNotRound) {
  double grid = 1.0;
  test::for_each_sweep(load_scene("exact-pyramid"),
                       [&](const Level& level, const VectorField& before, int number) {
                         if (number > 0) {
                           return;
                         }
                         int finer = 0;
                         for (const float value : before.x) {
                           const double multiple = static_cast<double>(value) / grid;
                           ASSERT_EQ(multiple, std::round(multiple)) << "level of " << level.extent.width;
                           finer += std::fmod(multiple, 16.0) != 0.0 ? 1 : 0;
                         }
                         EXPECT_GT(finer, 100) << "nothing was interpolated";
                         grid /= 16.0;
                       });
  EXPECT_EQ(grid, 0x1p-12);
}

TEST(Exactness, IsAPropertyOfTheDyadicTexture) {
  constexpr std::array extents{Extent{1, 1}, Extent{1, 9},  Extent{13, 1}, Extent{2, 2},
                               Extent{5, 8}, Extent{17, 3}, Extent{24, 19}};
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Update update = test::simultaneous_and_coloured[seed % 3];
    auto [level, field] =
        test::random_problem(extents[seed % extents.size()], Texture::dyadic, seed, {}, Rule::steps, update);
    for (int number = 0; number < 8; ++number) {
      const auto found = first_inexact(level, field, number);
      ASSERT_FALSE(found) << "seed " << seed << ": " << found->text();
      field = test::swept(level, field, number);
    }
  }
}

/// What the proof says of a dyadic problem that was changed.
template <typename Change>
std::string inexact_after(Change change) {
  auto problem = test::random_problem({9, 7}, Texture::dyadic, 5);
  EXPECT_FALSE(first_inexact(problem.level, problem.start, 0));
  change(problem);
  set_inverse_modulus(problem.level);
  set_inverse_curvature(problem.level);
  const auto found = first_inexact(problem.level, problem.start, 0);
  return found ? found->text() : "";
}

TEST(Exactness, RefusesStepsThatAreNotDyadic) {
  const std::string text =
      inexact_after([](test::Problem& problem) { problem.level.steps = StepSet::parse("0,-1,-0.1,1,0.1"); });
  EXPECT_THAT(text, HasSubstr("x = 0, y = 0, sweep 0: "));
  EXPECT_THAT(text, HasSubstr(" * -0.1: terms of up to "));
}

TEST(Exactness, LooksAtCandidatesThatAreNeverChosen) {
  EXPECT_THAT(inexact_after([](test::Problem& problem) {
                problem.level.steps = StepSet::parse("0,-1,-0.25,1,0.25,1000000.1");
              }),
              HasSubstr(" * 1000000.1: terms of up to "));
}

TEST(Exactness, RefusesModuliThatAreNoPowersOfTwo) {
  EXPECT_THAT(inexact_after([](test::Problem& problem) { problem.level.modulus.values.front() = 3.0F; }),
              HasSubstr("x = 0, y = 0, sweep 0: 1 / 3 is not a power of two"));
  // Its neighbours are refused by what the rounded 1 / 3 does to them.
  EXPECT_THAT(inexact_after([](test::Problem& problem) { problem.level.modulus.values[1] = 3.0F; }),
              testing::ContainsRegex("x = 0, y = 0, sweep 0: 1 \\+ .*33.*: terms"));
}

TEST(Exactness, RefusesValuesThatAreTooLarge) {
  EXPECT_THAT(inexact_after([](test::Problem& problem) { problem.start.x.back() = 0x1p22F; }),
              HasSubstr("x = 7, y = 5"));
  EXPECT_THAT(inexact_after([](test::Problem& problem) { problem.level.penalty = 0x1p28F; }),
              HasSubstr("268435460 * "));
  EXPECT_THAT(inexact_after([](test::Problem& problem) {
                problem.level.modulus.values[20] = 0x1p-120F;
                problem.level.modulus.values[21] = 0x1p-120F;
              }),
              HasSubstr("leaves the range"));
  EXPECT_THAT(
      inexact_after([](test::Problem& problem) { problem.level.steps = StepSet::parse("0,-1,0.001"); }),
      HasSubstr("the value 0.001, in units of 2^-33, leaves the range"));
}

// The thesis's K on the square: all sums have 24 bits, the difference of two of them has not.
TEST(Exactness, RefusesComparisonsWhoseDifferenceRounds) {
  Scene scene = load_scene("exact-square");
  scene.full.penalty = 1000.0F;
  EXPECT_THAT(inexact(scene), testing::ContainsRegex("sweep [0-9]+: .* < .*need 25 bits"));
}

TEST(Exactness, RefusesTheLastSiteOfTheLastRow) {
  EXPECT_THAT(inexact_after([](test::Problem& problem) { problem.level.target.y.back() = 0.1F; }),
              HasSubstr("x = 8, y = 6"));
}

TEST(Exactness, RefusesWhatIsNotFiniteOrSubnormal) {
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()}) {
    EXPECT_THAT(inexact_after([&](test::Problem& problem) { problem.start.y[30] = value; }),
                HasSubstr("is not finite"));
    EXPECT_THAT(inexact_after([&](test::Problem& problem) { problem.level.target.x[30] = value; }),
                HasSubstr("is not finite"));
  }
  EXPECT_THAT(inexact_after([](test::Problem& problem) { problem.start.x[30] = 0x1p-140F; }),
              HasSubstr("x = 2, y = 2"));
}

// Every operation of the specified order is exact: displacements are large, but their differences are small.
// A sum that begins with the displacements themselves would round.
TEST(Exactness, RefusesWhatOnlyAnotherOrderRounds) {
  auto [level, field] = test::random_problem({9, 7}, Texture::dyadic, 5);
  Level same = level;
  same.modulus = ScalarField(level.extent, 1.0F);
  same.confidence = VectorField(level.extent);
  set_inverse_modulus(same);
  for (float& value : field.x) {
    value += 0x1p19F;
  }
  const VectorField rounded = test::swept(same, field, 0);
  VectorField moved_back = field;
  for (float& value : moved_back.x) {
    value -= 0x1p19F;
  }
  const VectorField small = test::swept(same, moved_back, 0);
  for (std::size_t i = 0; i < field.x.size(); ++i) {
    EXPECT_EQ(rounded.x[i] - 0x1p19F, small.x[i]) << "the specified order rounds, too";
  }
  EXPECT_FALSE(first_inexact(same, moved_back, 0));
  EXPECT_TRUE(first_inexact(same, field, 0));
}

TEST(Exactness, RefusesRulesThatDivideAndRandomNumbers) {
  for (const Rule rule : {Rule::closed_form, Rule::annealing}) {
    const auto [level, field] = test::random_problem({9, 7}, Texture::dyadic, 5, {}, rule);
    EXPECT_TRUE(first_inexact(level, field, 0)) << static_cast<int>(rule);
  }
}

class ExactKey : public testing::Test {
protected:
  [[nodiscard]] Scene load(const std::string& schedule, const SceneOptions& options = {}) const {
    return load_scene(folder_
                          .write("mine.toml", "size = [32, 64]\nexact = " + declared_ +
                                                  "\nsteps = [0.0, -1.0, 1.0]\n[schedule]\n" + schedule +
                                                  "\n[random]\nseed = 1\nmoduli = [1.0, 2.0]\n"
                                                  "displacement = 4.0\ngrid = 1.0\nobserved = 0.5\n"
                                                  "confidences = [0.5, 1.0]\n")
                          .string(),
                      options);
  }
  [[nodiscard]] std::string refusal(const std::string& schedule) const {
    return test::refusal([&] { (void)load(schedule); });
  }

  test::TemporaryFolder folder_;
  std::string declared_ = "true";
};

TEST_F(ExactKey, IsTakenWhereThePyramidCanBeExact) {
  EXPECT_TRUE(load("start_level = 0").exact);
  EXPECT_TRUE(load("start_level = 2\nalignment = \"center\"").exact);
  declared_ = "false";
  EXPECT_FALSE(load("start_level = 0").exact);
}

TEST_F(ExactKey, IsRefusedWithTheLineAndWhatToDo) {
  EXPECT_THAT(
      refusal("start_level = 2"),
      testing::AllOf(HasSubstr("mine.toml:2"), HasSubstr("start_level = 0, or alignment = \"center\"")));
  EXPECT_THAT(refusal("method = \"annealing\"\nstart_level = 0"),
              HasSubstr("exact cannot be true: only icm"));
  EXPECT_THAT(refusal("update = \"sequential\"\nstart_level = 0"),
              HasSubstr("exact cannot be true: only icm"));
  declared_ = "1";
  EXPECT_THAT(refusal("start_level = 0"), HasSubstr("true or false"));
}

TEST_F(ExactKey, IsDroppedAtAnotherSizeWhereInterpolationRounds) {
  const std::string centred = "start_level = 2\nalignment = \"center\"";
  EXPECT_TRUE(load(centred, {.size = Extent{8, 128}}).exact);
  EXPECT_FALSE(load(centred, {.size = Extent{8, 129}}).exact);
  EXPECT_TRUE(load("start_level = 0", {.size = Extent{8, 129}}).exact);
}

} // namespace
} // namespace hdmbench
