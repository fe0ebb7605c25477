// Observations that are wrong: the elastic energy with springs whose pull stops growing.

#include "harness/judge/truths.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/robust_observations.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/planner.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/finite_elements.hpp"
#include "test/sessions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hdmbench {
namespace {

/// The square scene with its conditions, and its solution observed at a quarter of all other sites, 0.1 px
/// off; a fifth of these by 10 to 20 px more.
struct Observed {
  Scene scene = load_scene("square", {.size = Extent{61, 47}});
  VectorField truth;

  explicit Observed(std::uint64_t seed) {
    use_energy(scene, find_energy("elastic"));
    truth = Solver(test::scalar(), {}).solve(scene, test::silent()).displacement;
    std::mt19937_64 engine(seed);
    std::normal_distribution<float> noise(0.0F, 0.1F);
    std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
    Level& full = scene.full;
    for (std::size_t site = 0; site < full.extent.sites(); ++site) {
      if (full.confidence[0][site] == 0.0F && full.confidence[1][site] == 0.0F && uniform(engine) < 0.25F) {
        const float wrong = uniform(engine) < 0.2F ? 10.0F + 10.0F * uniform(engine) : 0.0F;
        full.target[0][site] = truth[0][site] + noise(engine) + wrong;
        full.target[1][site] = truth[1][site] + noise(engine) - wrong;
        full.confidence[0][site] = full.confidence[1][site] = confidence_of_deviation(2.0);
      }
    }
  }

  [[nodiscard]] double error(std::optional<double> forgiven) {
    scene.robust = forgiven;
    const VectorField field = Solver(test::find("openmp"), {}).solve(scene, test::silent()).displacement;
    return rmsd(ReferenceField(field), ReferenceField(truth));
  }
};

TEST(RobustObservations, ForgiveOutliers) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Observed observed(seed);
    const double plain = observed.error(std::nullopt);
    const double robust = observed.error(0.3);
    EXPECT_GT(plain, 1.0) << "seed " << seed;
    EXPECT_LT(robust, 0.15 * plain) << "seed " << seed;
    EXPECT_LT(robust, 0.6) << "seed " << seed;
    EXPECT_NEAR(observed.error(1e4), plain, 1e-3 * plain) << "nothing is that far away, seed " << seed;
  }
}

/// Finite elements in double, with the springs as they count in the end, come to the same field.
TEST(RobustObservations, SettleAtTheMinimum) {
  Observed observed(4);
  Scene& scene = observed.scene;
  scene.robust = 0.3;
  const auto session = test::find("openmp").open_elastic({});
  const RobustObservations robust = find_robust_observations(scene, *session, test::silent());
  EXPECT_LT(robust.moved, 1e-3 * 0.3);
  use_method(scene, find_method(elastic_conjugate_gradients), 30);
  const VectorField field = Solver(test::find("openmp"), {}).solve(scene, test::silent()).displacement;
  const ReferenceField again =
      solve_finite_elements(elastic_problem(reweighted(scene.full, field, *scene.robust)),
                            ElementRule::plane_stress(scene.poisson));
  EXPECT_LT(rmsd(ReferenceField(field), again), 0.01 * *scene.robust);
}

TEST(RobustObservations, AreTheSameBitsOnEveryBackend) {
  Observed observed(5);
  observed.scene.robust = 0.3;
  const auto field = [&](const Backend& backend) {
    return Solver(backend, {}).solve(observed.scene, test::silent()).displacement;
  };
  const VectorField expected = field(test::scalar());
  for (const auto& backend : test::backends()) {
    try {
      const VectorField other = field(*backend);
      EXPECT_EQ(compare(expected, other).sites, 0) << backend->name();
    } catch (const DeviceError& error) {
      fmt::print("{} is not here: {}\n", backend->name(), error.what());
    }
  }
}

TEST(RobustObservations, ArePlanned) {
  Observed observed(6);
  observed.scene.robust = 0.3;
  const Plan plan =
      solve_as_needed(observed.scene, {.accuracy = 0.01}, test::find("openmp"), {}, test::silent());
  EXPECT_TRUE(plan.met) << plan.outcome;
  EXPECT_EQ(plan.steps.front().action, "observations");
  EXPECT_LT(rmsd(ReferenceField(plan.solution.displacement), ReferenceField(observed.truth)), 0.25);
}

} // namespace
} // namespace hdmbench
