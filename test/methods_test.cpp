// Methods: their names and options, and how near they come. golden holds that all backends give the same
// bits.

#include "harness/scene/method.hpp"

#include "harness/judge/truths.hpp"
#include "harness/measure/bench.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/sites.hpp"
#include "reference/fixed_point.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

Scene with(Scene scene, std::string_view method, std::optional<int> iterations = std::nullopt) {
  use_method(scene, find_method(method), iterations);
  return scene;
}

TEST(Methods, AreReadFromSceneFiles) {
  const test::TemporaryFolder folder;
  const auto load = [&](const std::string& schedule) {
    return load_scene(
        folder
            .write("scene.toml", "size = [8, 6]\n[[tissue]]\nlabel = 1\nmodulus = 2.0\n[[shape]]\n"
                                 "kind = \"everything\"\nlabel = 1\n[schedule]\n" +
                                     schedule)
            .string());
  };
  const Scene scene = load("method = \"annealing\"\ntemperatures = [8.0, 0.5]\nseed = 5\n");
  EXPECT_EQ(scene.schedule.iterations, find_method("annealing").usual_effort);
  EXPECT_EQ(scene.schedule.cooling.highest, 8.0);
  EXPECT_EQ(scene.schedule.cooling.lowest, 0.5);
  EXPECT_EQ(scene.full.seed, 5);
  EXPECT_EQ(scene.schedule.rule, Rule::annealing);
  EXPECT_EQ(load("method = \"closed-form\"\nrelaxation = 0.5\n").schedule.relaxation.factor, 0.5);
  EXPECT_EQ(load("update = \"coloured\"\n").full.update, Update::coloured);
  EXPECT_THROW((void)load("method = \"cascade\"\nrelaxation = 0.5\n"), InputError);
  EXPECT_THROW((void)load("method = \"magic\"\n"), InputError);
}

TEST(Cascade, IsNearTheFixedPointForThreeSweeps) {
  const std::pair<const char*, double> scenes[]{
      {"square", 0.05}, {"circular", 0.16}, {"circular-radial", 0.4}};
  for (const auto& [name, most] : scenes) {
    const Scene scene = with(load_scene(name, {.size = Extent{300, 300}}), "cascade");
    const Solution solution = test::solved(scene, "openmp");
    EXPECT_LT(total_site_updates(solution.levels), 4.0 * 300 * 300) << name;
    EXPECT_LT(rmsd(ReferenceField(solution.displacement), solve_fixed_point(scene.full).displacement), most)
        << name;
    EXPECT_TRUE(std::ranges::none_of(solution.levels, &LevelResult::repeated)) << name;
  }
}

/// Stiff and soft layers in turn, aslant, so that their edges are stairs: the system has complex eigenvalues.
Scene slanting_layers(double contrast) {
  Scene scene = load_scene("square", {.size = Extent{96, 96}});
  for_each_site(scene.extent(), [&](int x, int y) {
    scene.full.modulus.values[scene.extent().index(x, y)] =
        static_cast<int>((0.8 * x + 0.6 * y) / 3.0) % 2 == 0 ? 1.0F : static_cast<float>(contrast);
  });
  set_inverse_modulus(scene.full);
  return scene;
}

TEST(Cascade, NoticesThatAccelerationDiverges) {
  for (const double contrast : {1e3, 1e4}) {
    const Scene scene = with(slanting_layers(contrast), "cascade", 4);
    const Solution solution = test::solved(scene, "openmp");
    EXPECT_TRUE(std::ranges::any_of(solution.levels, &LevelResult::repeated)) << contrast;
    for (const auto* component : {&solution.displacement[0], &solution.displacement[1]}) {
      for (const float value : *component) {
        ASSERT_LE(std::abs(value), 1.1 * 50.0) << contrast;
      }
    }
  }
}

TEST(Solve, UntilStillEndsAtAnExactFixedPoint) {
  Scene scene = load_scene("square", {.size = Extent{48, 48}});
  scene.schedule.stop = Stop::still;
  scene.schedule.iterations = 5000;
  const auto session = test::scalar().open({});
  const Solution solution = solve(scene, *session, test::silent(), {.last_changed = true});
  ASSERT_LT(solution.levels.back().iterations, 5000);
  EXPECT_EQ(solution.levels.back().changed, 0);
  session->step(10);
  EXPECT_EQ(compare(solution.displacement, test::read(*session)).sites, 0);
}

TEST(Solve, EveryStopRuleGivesTheSameFieldAndIterationsOnEveryBackend) {
  Scene scene = load_scene("circular", {.size = Extent{40, 33}});
  scene.schedule.iterations = 300;
  for (const Stop stop : {Stop::fixed, Stop::still, Stop::energy}) {
    scene.schedule.stop = stop;
    const Solution expected = test::solved(scene);
    for (const Backend* const backend : test::present_backends()) {
      const Solution found = test::solved(scene, backend->name());
      EXPECT_EQ(compare(expected.displacement, found.displacement).sites, 0) << backend->name();
      for (std::size_t i = 0; i < expected.levels.size(); ++i) {
        EXPECT_EQ(found.levels[i].iterations, expected.levels[i].iterations)
            << backend->name() << ", level " << i;
      }
    }
  }
}

} // namespace
} // namespace hdmbench
