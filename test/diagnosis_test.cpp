#include "harness/judge/diagnosis/diagnosis.hpp"

#include "harness/judge/diagnosis/measures.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/method.hpp"
#include "reference/fixed_point.hpp"
#include "test/scenes.hpp"

namespace hdmbench {
namespace {

using test::know_column;
using test::plain_scene;
using test::pulled_scene;

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

/// What is changed in a sheet that is pulled, and how many sites a warning is then about; `some`: at least
/// one.
TEST(BeforeTheRun, WarnsFromTheseThresholdsOn) {
  constexpr std::size_t some = 9999;
  struct Case {
    const char* kind;
    std::size_t sites;
    Scene scene;
    std::function<void(Scene&)> change;
  };
  const auto steps = [](const char* text) {
    return [text](Scene& scene) { scene.full.steps = StepSet::parse(text); };
  };
  const auto contrast = [](float value) {
    return [value](Scene& scene) { scene.full.modulus.values[40] = value; };
  };
  const auto schedule = [](int iterations, std::optional<int> start_level,
                           Alignment alignment = Alignment::corner) {
    return [=](Scene& scene) {
      scene.schedule.iterations = iterations;
      scene.schedule.start_level = start_level;
      scene.schedule.alignment = alignment;
    };
  };
  const Scene sheet = pulled_scene({9, 9}, 1.0F);
  const Scene large = pulled_scene({60, 60}, 1.0F);
  const auto hold = [](Scene& scene) {
    scene.full.confidence[0][1] = 0.01F;
    scene.full.confidence[1][1] = 0.01F;
  };
  const auto aim = [](float confidence) {
    return [confidence](Scene& scene) {
      scene.full.target[1][7] = -0.5F;
      scene.full.confidence[1][7] = confidence;
    };
  };
  const Case cases[] = {
      {"nothing-moves", some, plain_scene({5, 4}), hold},
      {"nothing-moves", some, plain_scene({5, 4}), aim(0.0F)},
      {"nothing-moves", 0, plain_scene({5, 4}), aim(0.01F)},
      {"nothing-moves", 0, plain_scene({5, 4}),
       [](Scene& scene) { scene.full.force = VectorField(scene.extent(), 1.0F); }},
      {"nothing-moves", some, plain_scene({5, 4}),
       [](Scene& scene) { scene.full.force = VectorField(scene.extent(), 0.0F); }},
      {"nothing-moves", 0, plain_scene({5, 4}),
       [](Scene& scene) { scene.start = VectorField(scene.extent(), 1.0F); }},
      {"undetermined", 20, plain_scene({5, 4}), [](Scene&) {}},
      {"undetermined", 0, plain_scene({5, 4}), hold},
      {"undetermined", 3, plain_scene({1, 4}), hold}, // nothing connects x
      {"lost-condition", 0, large, schedule(50, std::nullopt)},
      {"lost-condition", 120, large, schedule(50, std::nullopt, Alignment::center)},
      {"lost-condition", 0, large, schedule(50, 0, Alignment::center)}, // no level to be lost on
      {"offset", some, pulled_scene({9, 9}, 0x1p19F), [](Scene&) {}},   // an ulp is more than half of 0.1 px
      {"offset", 0, pulled_scene({9, 9}, 0x1p18F), [](Scene&) {}},
      {"offset", some, pulled_scene({9, 9}, 0x1p16F), steps("fine")},
      {"offset", 0, pulled_scene({9, 9}, 0x1p15F), steps("fine")},
      {"contrast", 0, sheet, contrast(1.6e7F)},
      {"contrast", some, sheet, contrast(1.8e7F)},
      {"contrast", some, sheet, contrast(1e19F)},
      {"never-rests", 0, sheet, [](Scene&) {}},
      {"never-rests", some, sheet, steps("thesis")},
  };
  for (const Case& one : cases) {
    Scene scene = one.scene;
    one.change(scene);
    const Warnings warnings = diagnose(scene);
    EXPECT_EQ(has(warnings, one.kind), one.sites > 0) << one.kind << '\n' << warnings_text(warnings);
    EXPECT_TRUE(one.sites == some || sites_of(warnings, one.kind) == one.sites) << one.kind;
  }
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
              static_cast<std::size_t>(std::ranges::count(field[0], 0.0F)))
        << iterations;
    EXPECT_EQ(has(diagnose(scene), "out-of-reach"), iterations == 32);
  }
  scene.schedule.iterations = 3;
  scene.schedule.start_level.reset();
  EXPECT_FALSE(has(diagnose(scene), "out-of-reach")) << "coarse levels bring it";
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

TEST(BeforeTheRun, SpringsOfAnElasticBodyGiveWayBetweenEachOther) {
  Scene scene = plain_scene({8, 3});
  know_column(scene, 3, 0.0F);
  know_column(scene, 4, -2.0F);
  use_energy(scene, find_energy("elastic"));
  EXPECT_TRUE(has(diagnose(scene), "conflict"));
  std::ranges::replace(scene.full.confidence[0], 1.0F, 0.5F);
  EXPECT_FALSE(has(diagnose(scene), "conflict"));
  use_energy(scene, usual_energy());
  EXPECT_TRUE(has(diagnose(scene), "conflict")) << "the thesis's energy observes them";
}

TEST(BeforeTheRun, AWeakPenaltyIsOneAtWhichConditionsGiveWay) {
  // 1 px per pixel: from so many K on, which so many conditions then hold.
  for (const auto& [extent, needed, conditions] :
       {std::tuple{Extent{11, 11}, 24.0F, 44U}, {Extent{7, 7, 7}, 72.0F, 294U}}) {
    Scene scene = pulled_scene(extent, static_cast<float>(extent.width - 1));
    for (const float penalty : {needed - 1.0F, needed + 1.0F}) {
      scene.full.penalty = penalty;
      const FixedPoint fixed_point = solve_fixed_point(scene.full);
      const bool weak = has(diagnose(scene), "weak-penalty");
      EXPECT_EQ(weak, penalty < needed);
      EXPECT_EQ(weak, fixed_point.held < conditions) << penalty;
    }
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
    const bool stays = solution.displacement[0][scene.extent().index(12, 12)] == 0.0F;
    EXPECT_EQ(stays, ratio > 100.0F);
    EXPECT_EQ(has(diagnose(scene), "stiff-boundary"), stays);
  }
}

TEST(BeforeTheRun, AVolumeThatHardlyChangesItsSizeIsNamed) {
  for (const auto& [extent, ratio, is_named] : {std::tuple{Extent{8, 8, 8}, 0.49, true},
                                                {Extent{8, 8, 8}, 0.45, false},
                                                {Extent{8, 8}, 0.49, false}}) {
    Scene scene = pulled_scene(extent, 10.0F);
    scene.elastic.poisson = ratio;
    use_energy(scene, find_energy("elastic"));
    EXPECT_EQ(has(diagnose(scene), "nearly-incompressible"), is_named) << extent.text() << ", " << ratio;
    EXPECT_EQ(has(diagnose(scene), "locking"), extent.axes() == 3 && ratio >= 0.45) << ratio;
    scene.elastic.integration = Integration::selective_reduced;
    EXPECT_FALSE(has(diagnose(scene), "locking"));
  }
}

TEST(BeforeTheRun, ResampledPixelsAreNamed) {
  Scene scene = pulled_scene({8, 8}, 10.0F);
  EXPECT_FALSE(has(diagnose(scene), "resampled"));
  scene.oblong = FileGrid{.extent = {8, 4}, .sides = {1.0, 2.0}};
  EXPECT_TRUE(has(diagnose(scene), "resampled"));
}

/// The length of the shortest way along neighbours, found by letting every site ask all around until none has
/// a shorter one.
std::vector<float> shortest_ways(Extent extent, const std::vector<float>& counted, float diagonal) {
  const auto sum_of_sides =
      static_cast<float>(extent.width + extent.height + (extent.depth > 1 ? extent.depth : 0));
  std::vector<float> ways(extent.sites());
  std::ranges::transform(counted, ways.begin(), [&](float value) { return value > 0.0F ? 0.0F : 1e9F; });
  for (bool is_shorter = true; is_shorter;) {
    is_shorter = false;
    for_each_site(extent, [&](int x, int y, int z) {
      for (int i = 0; i < 27; ++i) {
        const std::array at{x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1};
        if (std::ranges::min(at) < 0 || at[0] >= extent.width || at[1] >= extent.height ||
            at[2] >= extent.depth) {
          continue;
        }
        const int axes = (at[0] != x ? 1 : 0) + (at[1] != y ? 1 : 0) + (at[2] != z ? 1 : 0);
        float& own = ways[extent.index(x, y, z)];
        const float way = ways[extent.index(at[0], at[1], at[2])] + (axes > 1 ? diagonal : 1.0F);
        is_shorter = is_shorter || way < own;
        own = std::min(own, way);
      }
    });
  }
  std::ranges::transform(ways, ways.begin(), [&](float way) { return way >= 1e9F ? sum_of_sides : way; });
  return ways;
}

TEST(Distances, AreThoseOfTheShortestWays) {
  std::mt19937 random(7);
  for (const Extent extent : {Extent{1, 1}, Extent{1, 9}, Extent{9, 1}, Extent{23, 17}, Extent{2, 3, 11},
                              Extent{9, 8, 7}, Extent{13, 1, 6}}) {
    for (const unsigned sites : {0U, 1U, 3U}) {
      std::vector<float> counted(extent.sites());
      for (unsigned i = 0; i < sites; ++i) {
        counted[random() % counted.size()] = 0.5F;
      }
      for (const float diagonal : {1.0F, 1.5F}) { // what float adds up exactly
        EXPECT_EQ(diagnosis::distance_to_nearest(extent, counted, diagonal),
                  shortest_ways(extent, counted, diagonal))
            << extent.text() << ", " << sites << " sites, " << diagonal;
      }
    }
  }
}

TEST(Folding, TheLeastDeterminantOfACellIsAtACorner) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  for (int repeat = 0; repeat < 50; ++repeat) {
    VectorField field({2, 2});
    std::ranges::generate(field[0], [&] { return uniform(engine); });
    std::ranges::generate(field[1], [&] { return uniform(engine); });
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
        least =
            std::min(least, (1 + by_x(field[0])) * (1 + by_y(field[1])) - by_y(field[0]) * by_x(field[1]));
      }
    }
    const float ratio = least_area_ratios(field).values.front();
    EXPECT_NEAR(static_cast<double>(ratio), least, 1e-5);
    EXPECT_EQ(area_change_map(field).values, std::vector<float>(4, ratio - 1.0F))
        << "all four have this cell";
  }
}

TEST(Folding, OfAVolumeIsTheDeterminantOfThree) {
  VectorField field({4, 5, 3});
  const double gradient[3][3] = {{0.5, -0.25, 0.125}, {0.75, -0.5, 0.25}, {-0.375, 1.0, 0.625}};
  for_each_site(field.extent, [&](int x, int y, int z) {
    for (std::size_t i = 0; i < 3; ++i) {
      field[i][field.extent.index(x, y, z)] =
          static_cast<float>(gradient[i][0] * x + gradient[i][1] * y + gradient[i][2] * z);
    }
  });
  // 1.5 (0.5 * 1.625 - 0.25) + 0.25 (0.75 * 1.625 + 0.25 * 0.375) + 0.125 (0.75 + 0.5 * 0.375)
  const ScalarField ratios = least_area_ratios(field);
  EXPECT_EQ(ratios.extent, (Extent{3, 4, 2}));
  EXPECT_EQ(ratios.values, std::vector<float>(24, 1.2890625F));
  EXPECT_EQ(area_change_map(field).values, std::vector<float>(60, 0.2890625F));
  Scene scene = plain_scene(field.extent);
  EXPECT_FALSE(has(diagnose_field(scene, field), "fold-over"));
  field[2][field.extent.index(2, 3, 1)] -= 3.0F; // one site behind its neighbour: the eight cells around it
  EXPECT_THAT(warnings_text(diagnose_field(scene, field)), HasSubstr("of their volume"));
  EXPECT_GT(sites_of(diagnose_field(scene, field), "fold-over"), 0U);
}

/// The energy of neo-Hookean tissue with Poisson's ratio 0 has its inflection at 2.7 times the volume.
TEST(AfterTheRun, LawsGiveWayWhereTheyAreDilated) {
  const auto sites = [](double times, double poisson, float stiffening, Extent extent) {
    Scene scene = plain_scene(extent);
    scene.energy = &find_energy("elastic");
    scene.elastic.poisson = poisson;
    scene.full.law_parameter = ScalarField(extent, stiffening);
    VectorField field(extent);
    const double strain = std::cbrt(times) - 1.0;
    for_each_site(extent, [&](int x, int y, int z) {
      const std::array place{x, y, z};
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        field[axis][extent.index(x, y, z)] = static_cast<float>(strain * place[axis]);
      }
    });
    return sites_of(diagnose_field(scene, field), "dilated");
  };
  EXPECT_EQ(sites(2.6, 0.0, 0.0F, {5, 4, 6}), 4U * 3U * 5U);
  EXPECT_EQ(sites(2.6, 0.04, 3.0F, {5, 4, 6}), 4U * 3U * 5U);
  EXPECT_EQ(sites(2.4, 0.0, 0.0F, {5, 4, 6}), 0U);
  EXPECT_EQ(sites(2.6, 0.05, 0.0F, {5, 4, 6}), 0U);
  EXPECT_EQ(sites(2.6, 0.0, -1.0F, {5, 4, 6}), 0U) << "Hooke's law";
  EXPECT_EQ(sites(2.6, 0.0, 0.0F, {5, 4}), 0U) << "a membrane";
}

TEST(AfterTheRun, TheFixedPointIsWithoutWarnings) {
  for (const Extent extent : {Extent{33, 33}, {13, 12, 11}}) {
    Scene scene = pulled_scene(extent, 8.0F);
    const VectorField field = solve_fixed_point(scene.full).displacement.to_float();
    scene.schedule.rule = Rule::closed_form;
    const Warnings found = diagnose_field(scene, field);
    EXPECT_THAT(found, testing::IsEmpty()) << warnings_text(found);
    EXPECT_THAT(warnings_text(found), HasSubstr("nothing that speaks against this result"));
  }
}

TEST(AfterTheRun, WhatIsMissingAddsUpToTheDistance) {
  const Extent image{100, 100};
  const Extent volume{24, 24, 24};
  for (const auto& [name, extent] : {std::pair{"square", image},
                                     {"square-modified", image},
                                     {"circular", image},
                                     {"circular-radial", image},
                                     {"cube", volume},
                                     {"ball", volume}}) {
    const Scene scene = load_scene(name, {.size = extent});
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
}

TEST(AfterTheRun, ConditionsThatGiveWayAreToldFromThoseNotArrivedAt) {
  const Scene volume = pulled_scene({6, 5, 4}, 10.0F);
  EXPECT_EQ(sites_of(diagnose_field(volume, volume.start_field()), "not-met"), 20U) << "in all slices";
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
  field[0][60] = 4.9F; // a candidate of 1 px may overshoot
  EXPECT_FALSE(has(diagnose_field(scene, field), "divergence"));
  field[0][60] = 5.1F;
  EXPECT_EQ(sites_of(diagnose_field(scene, field), "divergence"), 1U);
  field[0][60] = 4.2F;
  scene.schedule.rule = Rule::closed_form;
  EXPECT_EQ(sites_of(diagnose_field(scene, field), "divergence"), 1U);
  field[0][60] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(sites_of(diagnose_field(scene, field), "not-finite"), 1U);
}

} // namespace
} // namespace hdmbench
