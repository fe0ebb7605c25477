// A.7: the search for alpha.

#include "harness/scene/sites.hpp"
#include "harness/solve/solve.hpp"
#include "harness/tools/tune.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

#include <cmath>
#include <utility>

namespace hdmbench {
namespace {

/// Targets of a smooth field with noise, every confidence between 0 and 1: neither all prior nor all
/// observation is right.
class Tune : public testing::Test {
protected:
  void SetUp() override {
    Level& full = scene_.full;
    std::mt19937_64 random(4);
    const auto uniform = [&] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
    std::ranges::fill(full.modulus.values, 20.0F);
    for_each_site(full.extent, [&](int x, int y) {
      const auto site = full.extent.index(x, y);
      truth_.displacement.x[site] = static_cast<float>(4.0 * std::sin(0.25 * x) + 0.1 * y);
      truth_.displacement.y[site] = static_cast<float>(3.0 * std::cos(0.2 * (x + y)));
      full.target.x[site] = truth_.displacement.x[site] + static_cast<float>(3.0 * (uniform() - 0.5));
      full.target.y[site] = truth_.displacement.y[site] + static_cast<float>(3.0 * (uniform() - 0.5));
      full.confidence.x[site] = static_cast<float>(uniform());
      full.confidence.y[site] = static_cast<float>(uniform());
    });
    set_inverse_modulus(full);
  }

  double rmsd_at(double alpha) {
    ++asked_;
    set_weight(scene_, {.penalty = 10.0, .prior_weight = alpha});
    return rmsd(solve(scene_, *session_, test::silent()).displacement, truth_);
  }

  Scene scene_ = load_scene("random", {.size = Extent{24, 24}});
  Truth truth_{.displacement = VectorField({24, 24}), .defined = {}};
  std::unique_ptr<Session> session_ = test::find("openmp").open({});
  int asked_ = 0;
};

TEST_F(Tune, BothSearchesFindTheBestAlphaOfAScan) {
  double best_of_scan = HUGE_VAL;
  double best_alpha = 0.0;
  for (int i = 1; i < 200; ++i) {
    if (const double found = rmsd_at(i / 200.0); found < best_of_scan) {
      best_of_scan = found;
      best_alpha = i / 200.0;
    }
  }
  EXPECT_GT(best_alpha, 0.1) << "the optimum must be inside for the test to mean anything";
  EXPECT_LT(best_alpha, 0.9);
  EXPECT_GT(std::min(rmsd_at(0.01), rmsd_at(0.99)), 1.2 * best_of_scan);
  for (const auto& [method, evaluations] :
       {std::pair{SearchMethod::simplex, 30}, {SearchMethod::annealing, 60}}) {
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
}

TEST_F(Tune, AFlatScanIsAllThatIsDone) {
  const Tuning tuning = tune_prior_weight([](double alpha) { return 1.0 + 1e-4 * alpha; }, {});
  EXPECT_FALSE(tuning.matters());
  EXPECT_EQ(tuning.evaluations.size(), 5U);
  EXPECT_EQ(tuning.best, 0U);
}

TEST_F(Tune, WhatHoldsTheConditionsIsAsGood) {
  const auto step = [](double alpha) { return alpha < 0.6 ? 1.0 : 1.0 + alpha; };
  const Tuning tuning = tune_prior_weight(step, {.method = SearchMethod::annealing, .evaluations = 40});
  EXPECT_TRUE(tuning.matters());
  EXPECT_NEAR(tuning.evaluations[tuning.best].prior_weight, 0.5, 1e-12) << "of equals the nearest to 0.5";
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

} // namespace
} // namespace hdmbench
