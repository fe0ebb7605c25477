#include "harness/solve/solve.hpp"

#include "harness/check/compare.hpp"
#include "harness/measure/bench.hpp"
#include "kernels/data/level.hpp"
#include "test/sessions.hpp"

#include <gtest/gtest.h>

namespace hdmbench {
namespace {

using test::solved;

TEST(Solve, TheSquareReachesItsBorderValues) {
  const Scene scene = load_scene("square", {.size = Extent{64, 64}});
  const Solution solution = solved(scene);
  EXPECT_EQ(solution.levels.size(), 7U);
  for (int y = 0; y < 64; ++y) {
    // A pinned site comes to rest within half the smallest step.
    EXPECT_NEAR(solution.displacement.x[scene.extent().index(0, y)], -50.0F, 0.0501F);
    EXPECT_NEAR(solution.displacement.x[scene.extent().index(63, y)], 0.0F, 0.0501F);
    EXPECT_NEAR(solution.displacement.y[scene.extent().index(y, 63)], 50.0F, 0.0501F);
  }
  // Softer in the middle: more of the displacement happens there than in as wide a strip of normal matter.
  const auto dx = [&](int x) { return solution.displacement.x[scene.extent().index(x, 32)]; };
  EXPECT_GT(dx(37) - dx(27), dx(15) - dx(5));
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
    const Solution expected = solved(scene);
    for (const auto& backend : test::backends()) {
      try {
        (void)backend->devices();
      } catch (const DeviceError&) {
        continue; // backends_test says so visibly
      }
      const Solution found = solved(scene, backend->name());
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
