// What methods do where they are hard put to it, and when they stop. Golden hashes hold what they give, and
// tools_test that scene files name them and their options.

#include "harness/scene/method.hpp"

#include "harness/scene/sites.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

Scene with(Scene scene, std::string_view method, std::optional<int> iterations = std::nullopt) {
  use_method(scene, find_method(method), iterations);
  return scene;
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
