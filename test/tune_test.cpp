// A.7: the search for alpha.

#include "harness/solve/solve.hpp"
#include "harness/tools/tune.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

#include <cmath>

namespace hdmbench {
namespace {

/// Targets of a smooth field with noise, every confidence between 0 and 1: neither all prior nor all
/// observation is right.
struct Noisy {
  Scene scene;
  Truth truth;
};

Noisy noisy_problem() {
  const Extent extent{24, 24};
  Noisy noisy{.scene = load_scene("random", {.size = extent}), .truth = {}};
  Level& full = noisy.scene.full;
  std::mt19937_64 random(4);
  const auto uniform = [&] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
  noisy.truth.displacement = VectorField(extent);
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const auto site = extent.index(x, y);
      full.modulus.values[site] = 20.0F;
      noisy.truth.displacement.x[site] = static_cast<float>(4.0 * std::sin(0.25 * x) + 0.1 * y);
      noisy.truth.displacement.y[site] = static_cast<float>(3.0 * std::cos(0.2 * (x + y)));
      const auto observe = [&](float value) {
        return static_cast<float>(double{value} + 3.0 * (uniform() - 0.5));
      };
      full.target.x[site] = observe(noisy.truth.displacement.x[site]);
      full.target.y[site] = observe(noisy.truth.displacement.y[site]);
      full.confidence.x[site] = static_cast<float>(uniform());
      full.confidence.y[site] = static_cast<float>(uniform());
    }
  }
  set_inverse_modulus(full);
  set_weight(noisy.scene, {.penalty = 10.0});
  return noisy;
}

class Tune : public testing::Test {
protected:
  double rmsd_at(double alpha) {
    ++asked_;
    set_weight(noisy_.scene, {.penalty = 10.0, .prior_weight = alpha});
    return rmsd(solve(noisy_.scene, *session_, test::silent()).displacement, noisy_.truth);
  }

  void expect_found(SearchMethod method, int evaluations) {
    double best_of_scan = HUGE_VAL;
    double best_alpha = 0.0;
    for (int i = 1; i < 200; ++i) {
      const double alpha = i / 200.0;
      const double found = rmsd_at(alpha);
      if (found < best_of_scan) {
        best_of_scan = found;
        best_alpha = alpha;
      }
    }
    EXPECT_GT(best_alpha, 0.1) << "the optimum must be inside for the test to mean anything";
    EXPECT_LT(best_alpha, 0.9);
    EXPECT_GT(std::min(rmsd_at(0.01), rmsd_at(0.99)), 1.2 * best_of_scan);
    asked_ = 0;
    const Tuning tuning = tune_prior_weight([this](double alpha) { return rmsd_at(alpha); },
                                            {.method = method, .evaluations = evaluations, .seed = 2});
    EXPECT_TRUE(tuning.matters());
    EXPECT_EQ(asked_, static_cast<int>(tuning.evaluations.size()));
    EXPECT_LE(asked_, evaluations + 10);
    const Evaluation& best = tuning.evaluations[tuning.best];
    EXPECT_NEAR(best.prior_weight, best_alpha, 0.05);
    EXPECT_LT(best.rmsd, best_of_scan + 0.005);
    EXPECT_LT(best.rmsd, tuning.evaluations[2].rmsd) << "better than what the scan saw at 0.5";
  }

  Noisy noisy_ = noisy_problem();
  std::unique_ptr<Session> session_ = test::find("openmp").open({});
  int asked_ = 0;
};

TEST_F(Tune, TheSimplexFindsTheBestAlphaOfAScan) {
  expect_found(SearchMethod::simplex, 30);
}

TEST(Simplex, FindsTheMinimumWithinItsEvaluations) {
  int asked = 0;
  const auto function = [&asked](double x) {
    ++asked;
    return (x - 1.3) * (x - 1.3);
  };
  EXPECT_NEAR(minimise_by_simplex(function, {.start = -2.0, .step = 1.0, .tolerance = 1e-3}), 1.3, 1e-3);
  EXPECT_GT(asked, 10);
  EXPECT_LE(asked, 50);
  asked = 0;
  (void)minimise_by_simplex(function, {.start = -2.0, .evaluations = 6});
  EXPECT_LE(asked, 12);
}

TEST_F(Tune, AnnealingFindsTheBestAlphaOfAScan) {
  expect_found(SearchMethod::annealing, 60);
}

TEST_F(Tune, AFlatScanIsAllThatIsDone) {
  const Tuning tuning = tune_prior_weight([](double alpha) { return 1.0 + 1e-4 * alpha; }, {});
  EXPECT_FALSE(tuning.matters());
  EXPECT_EQ(tuning.evaluations.size(), 5U);
  EXPECT_EQ(tuning.best, 0U);
  expect_refusal([] { (void)tune_prior_weight([](double) { return 1.0; }, {.low = 0.0}); }, "0 < low");
  expect_refusal([] { (void)tune_prior_weight([](double) { return 1.0; }, {.low = 0.6, .high = 0.5}); },
                 "low");
}

TEST_F(Tune, WhatHoldsTheConditionsIsAsGood) {
  const auto step = [](double alpha) { return alpha < 0.6 ? 1.0 : 1.0 + alpha; };
  const Tuning tuning = tune_prior_weight(step, {.method = SearchMethod::annealing, .evaluations = 40});
  EXPECT_TRUE(tuning.matters());
  EXPECT_NEAR(tuning.evaluations[tuning.best].prior_weight, 0.5, 1e-12) << "of equals the nearest to 0.5";
  EXPECT_EQ(tuning.plateau().low, tuning.evaluations[0].prior_weight);
  EXPECT_GE(tuning.plateau().high, 0.5);
  EXPECT_EQ(tuning.plateau().scanned, 3U);
}

TEST_F(Tune, AnOptimumAtTheEndStaysInTheRange) {
  const TuneOptions options{.method = SearchMethod::annealing, .low = 0.1, .high = 0.4};
  const Tuning tuning = tune_prior_weight([](double alpha) { return 1.0 - alpha; }, options);
  for (const Evaluation& evaluation : tuning.evaluations) {
    EXPECT_GE(evaluation.prior_weight, 0.1 - 1e-12);
    EXPECT_LE(evaluation.prior_weight, 0.4 + 1e-12);
  }
  EXPECT_NEAR(tuning.evaluations[tuning.best].prior_weight, 0.4, 1e-12);
}

TEST_F(Tune, TheRmsdCountsWhereTheTruthIsDefined) {
  VectorField displacement({2, 2});
  displacement.x = {3.0F, 0.0F, 0.0F, 1.0F};
  displacement.y = {4.0F, 0.0F, 0.0F, 1.0F};
  Truth truth{.displacement = VectorField({2, 2}), .defined = {}};
  EXPECT_DOUBLE_EQ(rmsd(displacement, truth), std::sqrt((25.0 + 2.0) / 4.0));
  truth.defined = ScalarField({2, 2});
  expect_refusal([&] { (void)rmsd(displacement, truth); }, "at no pixel");
  truth.defined.values = {255.0F, 255.0F, 0.0F, 0.0F};
  EXPECT_DOUBLE_EQ(rmsd(displacement, truth), std::sqrt(25.0 / 2.0));
  truth.displacement = VectorField({3, 2});
  expect_refusal([&] { (void)rmsd(displacement, truth); }, "the truth is 3 x 2");
}

TEST(Annealing, LeavesALocalMinimumAndRepeats) {
  // Minima near -2 (0.31) and 2 (0); a wall of height 1 between.
  const auto function = [](double x) {
    const double well = (x * x - 4.0) / 4.0;
    return well * well + 0.08 * (2.0 - x);
  };
  const SearchOptions options{.start = -2.0, .step = 1.0, .tolerance = 1e-3, .evaluations = 600};
  const double found = minimise_by_annealing(function, options, 1.0, 1);
  EXPECT_NEAR(found, 2.0, 0.15);
  EXPECT_EQ(minimise_by_annealing(function, options, 1.0, 1), found);
  EXPECT_NEAR(minimise_by_annealing(function, options, 0.0, 1), -2.0, 0.15) << "without heat it stays";
}

} // namespace
} // namespace hdmbench
