#include "harness/judge/diagnosis/diagnosis.hpp"

#include "harness/judge/accuracy/deviation.hpp"
#include "harness/judge/diagnosis/deformation.hpp"
#include "harness/judge/diagnosis/rest.hpp"
#include "harness/scene/method.hpp"
#include "reference/fixed_point.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>

namespace hdmbench {
namespace {

using test::know_column;
using test::plain_scene;
using test::pulled_scene;
using testing::HasSubstr;

bool has(const Warnings& warnings, std::string_view kind) {
  return std::ranges::find(warnings, kind, &Warning::kind) != warnings.end();
}

/// How many sites the warning is about; 0 where there is none.
std::size_t sites_of(const Warnings& warnings, std::string_view kind) {
  const auto found = std::ranges::find(warnings, kind, &Warning::kind);
  return found == warnings.end() ? 0 : found->sites.value_or(0);
}

/// The warnings after the run for a field that is given.
Warnings diagnose_field(const Scene& scene, const VectorField& displacement) {
  return diagnose(scene, Solution{.displacement = displacement, .levels = {}, .timings = {}});
}

TEST(BeforeTheRun, AComponentThatNothingFixesIsUndetermined) {
  Scene scene = plain_scene({5, 4});
  EXPECT_EQ(sites_of(diagnose(scene), "undetermined"), 20U);
  scene.full.confidence.x[7] = 0.01F;
  scene.full.confidence.y[7] = 0.01F;
  EXPECT_FALSE(has(diagnose(scene), "undetermined"));
  Scene thin = plain_scene({1, 4}); // nothing connects x
  thin.full.confidence.x[1] = 1.0F;
  thin.full.confidence.y[1] = 1.0F;
  EXPECT_EQ(sites_of(diagnose(thin), "undetermined"), 3U);
}

TEST(BeforeTheRun, ConditionsTravelOneSitePerIteration) {
  Scene scene = pulled_scene({65, 9}, 5.0F);
  know_column(scene, 0, 5.0F); // from both sides to the middle
  scene.schedule.rule = Rule::closed_form;
  scene.full.rule = Rule::closed_form; // the level is stepped by hand
  scene.full.strengths = {1.0F};
  set_inverse_curvature(scene.full);
  const auto session = test::scalar().open({});
  for (const int iterations : {32, 33}) {
    scene.schedule.iterations = iterations;
    test::begin(*session, scene.full, scene.start_field());
    session->step(iterations);
    const VectorField field = test::read(*session);
    EXPECT_EQ(sites_of(diagnose(scene), "out-of-reach"),
              static_cast<std::size_t>(std::ranges::count(field.x, 0.0F)))
        << iterations;
    EXPECT_EQ(has(diagnose(scene), "out-of-reach"), iterations == 32);
  }
  scene.schedule.iterations = 3;
  scene.schedule.start_level.reset();
  EXPECT_FALSE(has(diagnose(scene), "out-of-reach")) << "coarse levels bring it";
}

TEST(BeforeTheRun, StepsHaveToCoverTheWay) {
  Scene scene = pulled_scene({17, 17}, 10.0F);
  scene.schedule.iterations = 9;
  EXPECT_EQ(sites_of(diagnose(scene), "too-few-steps"), 17U);
  scene.schedule.iterations = 10;
  EXPECT_FALSE(has(diagnose(scene), "too-few-steps"));
  scene.schedule.iterations = 2;
  scene.schedule.start_level = 5; // 6 levels, 12 iterations
  EXPECT_FALSE(has(diagnose(scene), "too-few-steps"));
}

TEST(BeforeTheRun, CenterAlignmentLosesABorder) {
  Scene scene = pulled_scene({60, 60}, 1.0F);
  scene.schedule.start_level.reset();
  EXPECT_FALSE(has(diagnose(scene), "lost-condition"));
  scene.schedule.alignment = Alignment::center;
  EXPECT_EQ(sites_of(diagnose(scene), "lost-condition"), 120U);
  scene.schedule.start_level = 0;
  EXPECT_FALSE(has(diagnose(scene), "lost-condition")) << "no level to be lost on";
}

TEST(BeforeTheRun, CoarseLevelsStepOverALongThinRegion) {
  Scene scene = pulled_scene({64, 64}, 1.0F);
  scene.schedule.start_level.reset();
  int skipped = 0; // a column that the 32 x 32 level does not sample
  for (int i = 0; i < 10; ++i) {
    skipped = std::max(skipped, sampled_index(i, 32, 64, Alignment::corner) + 1);
  }
  const auto paint = [&](int length) {
    scene.full.modulus = ScalarField(scene.extent(), 1.0F);
    for (int y = 0; y < length; ++y) {
      scene.full.modulus.values[scene.extent().index(skipped, y)] = 5.0F;
    }
  };
  paint(4);
  EXPECT_EQ(sites_of(diagnose(scene), "lost-tissue"), 4U);
  paint(3);
  EXPECT_FALSE(has(diagnose(scene), "lost-tissue")) << "shorter than two sites of the level";
  paint(40);
  EXPECT_TRUE(has(diagnose(scene), "lost-tissue"));
  scene.schedule.mean_modulus = true;
  EXPECT_FALSE(has(diagnose(scene), "lost-tissue"));
}

TEST(BeforeTheRun, NeighbouringConditionsFoldFromOnePixelOn) {
  for (const auto& [second, conflicts] :
       {std::pair{-1.0F, true}, {-0.99F, false}, {1.0F, false}, {1.01F, true}}) {
    Scene scene = plain_scene({8, 3});
    know_column(scene, 3, 0.0F);
    know_column(scene, 4, second);
    EXPECT_EQ(sites_of(diagnose(scene), "conflict"), conflicts ? 3U : 0U) << second;
    for (int column = 5; column < 8; ++column) {
      know_column(scene, column, second);
    }
    EXPECT_EQ(has(diagnose_field(scene, scene.full.target), "fold-over"), second <= -1.0F);
  }
}

TEST(BeforeTheRun, AWeakPenaltyIsOneAtWhichConditionsGiveWay) {
  Scene scene = pulled_scene({11, 11}, 10.0F); // 1 px per pixel: K = 24
  for (const float penalty : {23.0F, 25.0F}) {
    scene.full.penalty = penalty;
    const FixedPoint fixed_point = solve_fixed_point(scene.full);
    const bool weak = has(diagnose(scene), "weak-penalty");
    EXPECT_EQ(weak, penalty < 24.0F);
    EXPECT_EQ(weak, fixed_point.held < 44U) << penalty;
  }
}

TEST(BeforeTheRun, AHugePenaltySwampsThePrior) {
  Scene scene = pulled_scene({9, 9}, 1.0F);
  scene.full.penalty = 2.0e7F;
  EXPECT_FALSE(has(diagnose(scene), "swamping-penalty"));
  scene.full.penalty = 2.1e7F;
  EXPECT_TRUE(has(diagnose(scene), "swamping-penalty"));
}

TEST(BeforeTheRun, FloatResolvesNoStepFarFromZero) {
  // ulp(2^19) = 1/16 px, beyond half of 0.1 px; ulp(2^16) = 1/128 px, beyond half of 0.01 px.
  const auto warns = [](float offset, const StepSet& steps) {
    Scene scene = pulled_scene({9, 9}, offset);
    scene.full.steps = steps;
    return has(diagnose(scene), "offset");
  };
  EXPECT_TRUE(warns(0x1p19F, StepSet()));
  EXPECT_FALSE(warns(0x1p18F, StepSet()));
  EXPECT_TRUE(warns(0x1p16F, StepSet::parse("fine")));
  EXPECT_FALSE(warns(0x1p15F, StepSet::parse("fine")));
}

TEST(BeforeTheRun, WhereWarnedOfTheFieldDependsOnTheOffset) {
  const auto solved = [](float offset) {
    Scene scene = pulled_scene({33, 33}, 8.0F);
    for (float& target : scene.full.target.x) {
      target += offset;
    }
    std::ranges::fill(scene.start.emplace(scene.start_field()).x, offset);
    scene.schedule.start_level.reset();
    scene.schedule.iterations = 200;
    VectorField field = test::solved(scene).displacement;
    for (float& component : field.x) {
      component -= offset;
    }
    return std::pair(ReferenceField(field), has(diagnose(scene), "offset"));
  };
  const ReferenceField unmoved = solved(0.0F).first;
  for (const float offset : {0x1p10F, 0x1p14F, 0x1p17F, 0x1p20F}) {
    const auto [field, warned] = solved(offset);
    const double distance = rmsd(field, unmoved);
    fmt::print("offset {:.0f} px: the field changes by {:.3g} px\n", offset, distance);
    EXPECT_EQ(warned, distance > 0.05) << offset; // half a candidate
  }
}

TEST(BeforeTheRun, AStiffLayerIsMovedByNoCandidate) {
  for (const float ratio : {2.0F, 300.0F}) {
    Scene scene = pulled_scene({24, 24}, 10.0F);
    for (std::size_t i = 0; i < scene.extent().sites(); ++i) {
      const std::size_t column = i % 24;
      scene.full.modulus.values[i] = column >= 10 && column < 14 ? ratio : 1.0F;
    }
    set_inverse_modulus(scene.full);
    scene.schedule.iterations = 2000;
    const Solution solution = test::solved(scene);
    const bool stays = solution.displacement.x[scene.extent().index(12, 12)] == 0.0F;
    EXPECT_EQ(stays, ratio > 100.0F);
    EXPECT_EQ(has(diagnose(scene), "stiff-boundary"), stays);
  }
}

TEST(BeforeTheRun, ContrastsThatFloatCannotHold) {
  Scene scene = pulled_scene({9, 9}, 1.0F);
  const auto message = [&](float ratio) {
    scene.full.modulus.values[40] = ratio;
    const Warnings warnings = diagnose(scene);
    const auto found = std::ranges::find(warnings, "contrast", &Warning::kind);
    return found == warnings.end() ? std::string("none") : found->message;
  };
  EXPECT_EQ(message(1.6e7F), "none");
  EXPECT_THAT(message(1.8e7F), HasSubstr("does not feel"));
  EXPECT_THAT(message(1e19F), HasSubstr("beyond float32"));
}

TEST(BeforeTheRun, WithoutZeroAmongTheCandidatesNothingRests) {
  Scene scene = pulled_scene({9, 9}, 1.0F);
  EXPECT_FALSE(has(diagnose(scene), "never-rests"));
  scene.full.steps = StepSet::parse("thesis");
  EXPECT_TRUE(has(diagnose(scene), "never-rests"));
}

TEST(BeforeTheRun, OfTheElasticEnergyConflictsAndStallingCyclesAreTold) {
  Scene scene = load_scene("square", {.size = Extent{24, 24}});
  use_method(scene, find_method(elastic_full_multigrid));
  EXPECT_FALSE(has(diagnose(scene), "stalling-cycles"));
  scene.full.modulus.values[scene.extent().index(3, 4)] *= 101.0F;
  EXPECT_TRUE(has(diagnose(scene), "stalling-cycles"));
  use_method(scene, find_method(elastic_conjugate_gradients));
  EXPECT_FALSE(has(diagnose(scene), "stalling-cycles"));
  const std::size_t before = sites_of(diagnose(scene), "conflict");
  for (const int x : {10, 11}) {
    const std::size_t at = scene.extent().index(x, 12);
    scene.full.confidence.x[at] = 1.0F;
    scene.full.target.x[at] = x == 10 ? 2.0F : -2.0F;
  }
  EXPECT_EQ(sites_of(diagnose(scene), "conflict"), before + 1U);
  EXPECT_EQ(diagnose(scene).size(), 1U) << "what is about the thesis's energy is not said";
}

TEST(Folding, TheLeastDeterminantOfACellIsAtACorner) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  for (int repeat = 0; repeat < 50; ++repeat) {
    VectorField field({2, 2});
    std::ranges::generate(field.x, [&] { return uniform(engine); });
    std::ranges::generate(field.y, [&] { return uniform(engine); });
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= 10; ++i) {
      for (int j = 0; j <= 10; ++j) {
        const double u = i / 10.0;
        const double v = j / 10.0;
        const auto by_x = [&](const std::vector<float>& d) {
          return (1 - v) * static_cast<double>(d[1] - d[0]) + v * static_cast<double>(d[3] - d[2]);
        };
        const auto by_y = [&](const std::vector<float>& d) {
          return (1 - u) * static_cast<double>(d[2] - d[0]) + u * static_cast<double>(d[3] - d[1]);
        };
        least = std::min(least, (1 + by_x(field.x)) * (1 + by_y(field.y)) - by_y(field.x) * by_x(field.y));
      }
    }
    EXPECT_NEAR(static_cast<double>(least_area_ratios(field).values.front()), least, 1e-5);
  }
}

TEST(Folding, ThresholdsAreZeroAndATenth) {
  Scene scene = plain_scene({6, 4});
  for (const auto& [rise, folds, nearly] :
       {std::tuple{-1.0F, true, false}, {-0.95F, false, true}, {-0.85F, false, false}}) {
    VectorField field(scene.extent());
    for (int y = 0; y < 4; ++y) {
      for (int x = 3; x < 6; ++x) {
        field.x[scene.extent().index(x, y)] = rise;
      }
    }
    EXPECT_EQ(sites_of(diagnose_field(scene, field), "fold-over"), folds ? 3U : 0U) << rise;
    EXPECT_EQ(sites_of(diagnose_field(scene, field), "near-fold"), nearly ? 3U : 0U) << rise;
    EXPECT_FLOAT_EQ(area_change_map(field).values[scene.extent().index(2, 1)], rise);
    EXPECT_EQ(area_change_map(field).values[scene.extent().index(5, 1)], 0.0F);
  }
  EXPECT_TRUE(least_area_ratios(VectorField({1, 7})).values.empty());
}

TEST(AfterTheRun, TheFixedPointIsWithoutWarnings) {
  Scene scene = pulled_scene({33, 33}, 8.0F);
  const VectorField field = solve_fixed_point(scene.full).displacement.to_float();
  scene.schedule.rule = Rule::closed_form;
  const Warnings found = diagnose_field(scene, field);
  EXPECT_THAT(found, testing::IsEmpty()) << warnings_text(found);
  EXPECT_THAT(warnings_text(found), HasSubstr("nothing that speaks against this result"));
}

TEST(AfterTheRun, WhatIsMissingAddsUpToTheDistance) {
  for (const std::string name : {"square", "square-modified", "circular", "circular-radial"}) {
    const Scene scene = load_scene(name, {.size = Extent{100, 100}});
    const Solution solution = test::solved(scene);
    const double estimate = accumulated_distance(scene, measure_rest(scene, solution.displacement).missing);
    const double distance =
        rmsd(ReferenceField(solution.displacement), solve_fixed_point(scene.full).displacement);
    EXPECT_LT(estimate, 3.0 * distance) << name;
    EXPECT_GT(estimate, distance / 3.0) << name;
    EXPECT_EQ(has(diagnose(scene, solution), "stalled"), estimate > 0.1) << name;
  }
}

TEST(AfterTheRun, ARunThatEndsEarlyIsStillMoving) {
  Scene scene = pulled_scene({33, 33}, 8.0F);
  scene.schedule.iterations = 40;
  EXPECT_TRUE(has(diagnose(scene, test::solved(scene)), "still-moving"));
  scene.schedule.iterations = 20000;
  scene.schedule.stop = Stop::still;
  EXPECT_FALSE(has(diagnose(scene, test::solved(scene)), "still-moving"));
}

TEST(AfterTheRun, SwappingSitesAndStripesAreOscillation) {
  Scene scene = load_scene("square", {.size = Extent{48, 48}});
  EXPECT_FALSE(has(diagnose(scene, test::solved(scene)), "oscillation"));
  scene.full.steps = StepSet::parse("thesis");
  EXPECT_GT(sites_of(diagnose(scene, test::solved(scene)), "oscillation"), 1000U);

  scene = pulled_scene({33, 33}, 8.0F);
  VectorField field = solve_fixed_point(scene.full).displacement.to_float();
  scene.schedule.rule = Rule::closed_form;
  const VectorField smooth = field;
  for (int y = 0; y < 33; ++y) {
    for (int x = 1; x < 32; ++x) {
      field.x[scene.extent().index(x, y)] += x % 2 == 0 ? 0.02F : -0.02F;
    }
  }
  EXPECT_TRUE(has(diagnose_field(scene, field), "oscillation"));
  field = smooth;
  for (int y = 0; y < 33; ++y) {
    for (int x = 1; x < 32; ++x) {
      field.x[scene.extent().index(x, y)] += 0.3F * std::sin(0.2F * static_cast<float>(x));
    }
  }
  EXPECT_FALSE(has(diagnose_field(scene, field), "oscillation"));
}

TEST(AfterTheRun, ConditionsThatGiveWayAreToldFromThoseNotArrivedAt) {
  Scene scene = pulled_scene({11, 11}, 10.0F);
  EXPECT_EQ(sites_of(diagnose_field(scene, scene.start_field()), "not-met"), 11U);
  EXPECT_FALSE(has(diagnose_field(scene, scene.start_field()), "gives-way"));
  scene.schedule.iterations = 3000;
  const Warnings held = diagnose(scene, test::solved(scene));
  EXPECT_FALSE(has(held, "not-met") || has(held, "gives-way")) << warnings_text(held);
  scene.full.penalty = 15.0F;
  const VectorField field = solve_fixed_point(scene.full).displacement.to_float();
  scene.schedule.rule = Rule::closed_form;
  const Warnings weak = diagnose_field(scene, field);
  EXPECT_TRUE(has(weak, "gives-way"));
  EXPECT_FALSE(has(weak, "not-met")) << warnings_text(weak);
}

TEST(AfterTheRun, ValuesBeyondConditionsAndStartAreDivergence) {
  Scene scene = pulled_scene({11, 11}, 4.0F);
  VectorField field(scene.extent(), 0.0F);
  field.x[60] = 4.9F; // a candidate of 1 px may overshoot
  EXPECT_FALSE(has(diagnose_field(scene, field), "divergence"));
  field.x[60] = 5.1F;
  EXPECT_EQ(sites_of(diagnose_field(scene, field), "divergence"), 1U);
  field.x[60] = 4.2F;
  scene.schedule.rule = Rule::closed_form;
  EXPECT_EQ(sites_of(diagnose_field(scene, field), "divergence"), 1U);
  field.x[60] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(sites_of(diagnose_field(scene, field), "not-finite"), 1U);
}

TEST(Diagnosis, IsTheWorkOfAFewSweeps) {
  const Scene scene = load_scene("circular");
  const auto session = test::scalar().open({});
  test::begin(*session, scene.full, scene.start_field());
  const auto seconds = [](const auto& call) {
    const auto begin = std::chrono::steady_clock::now();
    call();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const double sweep = seconds([&] { session->step(50); }) / 50.0;
  const double before = seconds([&] { (void)diagnose(scene); });
  const double after = seconds([&] { (void)diagnose_field(scene, scene.start_field()); });
  RecordProperty("sweeps_before", std::to_string(before / sweep));
  RecordProperty("sweeps_after", std::to_string(after / sweep));
  std::cout << "before the run " << before / sweep << ", after it " << after / sweep << " sweeps of scalar\n";
  EXPECT_LT(before + after, 200.0 * sweep); // an accident, not noise
}

TEST(Run, PrintsAndWritesItsWarnings) {
  const test::TemporaryFolder folder;
  const std::string at = folder.path().string();
  test::expect_run(0,
                   "run square --size 32 --steps thesis --output " + at + "/out --json " + at + "/run.json",
                   AllOf(HasSubstr("never-rests"), HasSubstr("-> --steps default")));
  const auto row = test::read_json(at + "/run.json")["results"][0];
  EXPECT_EQ(row["warnings"][0]["kind"], "never-rests");
  if (row.contains("pictures")) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / std::string(row["pictures"]["jacobian"])));
  }
}

} // namespace
} // namespace hdmbench
