#include "kernels/data/input_error.hpp"
#include "test/elastic_checks.hpp"
#include "test/files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace hdmbench {
namespace {

using namespace test;
using testing::HasSubstr;

TEST(FiniteElements, AffineBorderGivesTheAffineField) {
  for (const double nu : {-0.5, 0.0, 0.3, 0.5}) {
    EXPECT_LT(patch_error(ElementRule::plane_stress(nu)), 1e-10) << "nu " << nu;
  }
  EXPECT_GT(patch_error(ElementRule::plane_stress(0.3), 0.5), 1e-3) << "a soft pixel went unseen";
}

TEST(FiniteElements, ManufacturedSolutionsConvergeWithOrderTwo) {
  for (const double nu : {0.0, 0.3}) {
    for (const bool varying_modulus : {false, true}) {
      EXPECT_GE(observed_order(ElementRule::plane_stress(nu), nu, varying_modulus), 1.9)
          << "nu " << nu << (varying_modulus ? ", varying modulus" : "");
      EXPECT_LT(manufactured_error(ElementRule::plane_stress(nu), nu, 65, varying_modulus), 1e-3);
    }
  }
}

TEST(FiniteElements, BarOfTwoMaterialsIsSpringsInSeries) {
  EXPECT_LT(bar_error(ElementRule::plane_stress(0.0)), 1e-12);
  EXPECT_GT(bar_error(ElementRule::plane_stress(0.3)), 1e-3) << "with nu the bar is no bar of springs";
}

TEST(FiniteElements, EnergiesAreTheClosedForms) {
  for (const double nu : {0.0, 0.3, 0.5}) {
    EXPECT_LT(energy_error(ElementRule::plane_stress(nu), nu), 1e-13);
  }
}

TEST(FiniteElements, RigidMotionHasNoEnergy) {
  ElasticProblem problem = random_sheet({7, 5});
  problem.spring = {};
  for (const std::size_t rigid : {0U, 3U}) {
    const double energy = elastic_energy(problem, ElementRule::plane_stress(0.3),
                                         sampled(problem.extent, affine_fields[rigid]));
    EXPECT_NEAR(energy, 0.0, 1e-11); // rounding of 24 elements of up to 51 MPa moved by 4 px
  }
}

TEST(FiniteElements, MirroredAndTransposedProblemsHaveMirroredAndTransposedSolutions) {
  const ElementRule rule = ElementRule::plane_stress(0.3);
  EXPECT_LT(mirror_error(rule), 1e-11);
  EXPECT_LT(transposition_error(rule), 1e-11);
}

TEST(FiniteElements, EveryGaussPointHasTheModulusOfItsPixel) {
  // x * y on one element, nu = 0: twice the energy is the sum of m / 4 (y^2 + x^2 / 2) over the points.
  ElasticProblem problem = clamped_sheet({2, 2}, affine_fields[0]);
  problem.modulus = {1.0, 10.0, 100.0, 1000.0};
  const double low = 0.5 - 0.5 / std::sqrt(3.0);
  const double high = 0.5 + 0.5 / std::sqrt(3.0);
  const auto term = [](double modulus, double x, double y) { return modulus / 4.0 * (y * y + x * x / 2.0); };
  const double expected =
      term(1.0, low, low) + term(10.0, high, low) + term(100.0, low, high) + term(1000.0, high, high);
  EXPECT_NEAR(elastic_energy(problem, ElementRule::plane_stress(0.0),
                             sampled({2, 2},
                                     [](double x, double y) {
                                       return Vector{x * y, 0.0};
                                     })),
              expected, 1e-12 * expected);
}

TEST(FiniteElements, PlantedMistakesFailTheChecks) {
  const double nu = 0.3;
  const ElementRule good = ElementRule::plane_stress(nu);
  ElementRule shear = good;
  shear.elasticity(2, 2) *= 2.0; // 1 - nu instead of (1 - nu) / 2
  ElementRule plane_strain = good;
  plane_strain.elasticity(0, 1) = plane_strain.elasticity(1, 0) = good.elasticity(0, 1) * 1.05;
  ElementRule point_missing = good;
  point_missing.points.pop_back();
  ElementRule weights = good;
  for (QuadraturePoint& point : weights.points) {
    point.weight = 0.5;
  }
  for (const auto& [name, rule] :
       {std::pair{"shear", shear}, std::pair{"coupling", plane_strain},
        std::pair{"point missing", point_missing}, std::pair{"weights", weights}}) {
    EXPECT_GT(energy_error(rule, nu), 1e-3) << name;
    EXPECT_LT(observed_order(rule, nu), 1.0) << name;
  }
  // Of the right sum, so only what is not constant over an element shows it.
  ElementRule lopsided = good;
  lopsided.points[0].weight = lopsided.points[3].weight = 1.1;
  lopsided.points[1].weight = lopsided.points[2].weight = 0.9;
  EXPECT_GT(mirror_error(lopsided), 1e-3);
  EXPECT_GT(transposition_error(lopsided), 1e-3);
  ElementRule corners = good;
  for (QuadraturePoint& point : corners.points) {
    point.r = std::copysign(1.0, point.r);
    point.s = std::copysign(1.0, point.s);
  }
  EXPECT_GT(energy_error(corners, nu), 1e-3);
}

/// A bar without any modulus to speak of against two springs: each end follows its own target.
TEST(FiniteElements, ASpringSharesTheWayWithTheTissue) {
  Level level{.extent = {2, 2},
              .target = VectorField({2, 2}),
              .confidence = VectorField({2, 2}),
              .modulus = ScalarField({2, 2}, 3.0F)};
  // The left side is held, the right one pulled by 1 pixel; y is held everywhere.
  level.target.x = {0.0F, 1.0F, 0.0F, 1.0F};
  level.confidence.y = {1.0F, 1.0F, 1.0F, 1.0F};
  for (const float confidence : {0.2F, 0.5F, 0.9F}) {
    level.confidence.x = {1.0F, confidence, 1.0F, confidence};
    set_inverse_modulus(level);
    const ReferenceField field =
        solve_finite_elements(elastic_problem(level), ElementRule::plane_stress(0.0));
    // The square resists with its modulus over its height of one pixel, half of it on each of the two sites.
    const double share = static_cast<double>(confidence);
    const double spring = share / (1.0 - share);
    EXPECT_NEAR(field.x[1], spring / (spring + 0.5), 1e-6);
  }
}

TEST(FiniteElements, ObservedComponentsAreKept) {
  Level level = random_problem({20, 15}, Texture::smooth, 3).level;
  for (auto* const confidences : {&level.confidence.x, &level.confidence.y}) {
    std::ranges::transform(*confidences, confidences->begin(),
                           [](float confidence) { return confidence > 0.0F ? 1.0F : 0.0F; });
  }
  const ReferenceField field = solve_finite_elements(elastic_problem(level), ElementRule::plane_stress(0.3));
  int kept = 0;
  for (std::size_t i = 0; i < level.extent.sites(); ++i) {
    if (level.confidence.x[i] > 0.0F) {
      EXPECT_EQ(field.x[i], static_cast<double>(level.target.x[i]));
      ++kept;
    }
    if (level.confidence.y[i] > 0.0F) {
      EXPECT_EQ(field.y[i], static_cast<double>(level.target.y[i]));
    }
  }
  EXPECT_GT(kept, 20);
}

std::string refusal(const std::function<void(ElasticProblem&)>& spoil) {
  ElasticProblem problem = clamped_sheet({4, 3}, affine_fields[1]);
  spoil(problem);
  return test::refusal([&] { (void)solve_finite_elements(problem, ElementRule::plane_stress(0.3)); });
}

TEST(FiniteElements, ASheetThatIsFreeToMoveIsRefused) {
  const auto only = [](std::vector<std::pair<int, int>> in_x, std::vector<std::pair<int, int>> in_y) {
    return [in_x, in_y](ElasticProblem& problem) {
      std::ranges::fill(problem.fixed_x, std::uint8_t{0});
      std::ranges::fill(problem.fixed_y, std::uint8_t{0});
      for (const auto& [x, y] : in_x) {
        problem.fixed_x[problem.extent.index(x, y)] = 1;
      }
      for (const auto& [x, y] : in_y) {
        problem.fixed_y[problem.extent.index(x, y)] = 1;
      }
    };
  };
  EXPECT_THAT(refusal(only({}, {{0, 0}, {1, 0}})), HasSubstr("no site has a known displacement in x"));
  EXPECT_THAT(refusal(only({{0, 0}, {0, 1}}, {})), HasSubstr("no site has a known displacement in y"));
  EXPECT_THAT(refusal(only({{0, 1}, {3, 1}}, {{2, 0}, {2, 2}})), HasSubstr("it can turn about x = 2, y = 1"));
  EXPECT_EQ(refusal(only({{0, 1}, {3, 2}}, {{2, 0}})), "accepted");
  EXPECT_EQ(refusal(only({{0, 0}, {0, 1}}, {{2, 2}})), "accepted");
  EXPECT_EQ(refusal(only({{0, 1}}, {{2, 0}, {1, 0}})), "accepted");
  EXPECT_EQ(refusal(only({{0, 2}}, {{2, 0}, {1, 0}})), "accepted");
}

TEST(FiniteElements, BadInputIsRefused) {
  EXPECT_EQ(refusal([](ElasticProblem&) {}), "accepted");
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.modulus[5] = 0.0; }), HasSubstr("x = 1, y = 1 is 0 MPa"));
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.modulus[5] = std::nan(""); }), HasSubstr("12 finite values"));
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.modulus.pop_back(); }), HasSubstr("the modulus"));
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.fixed_y.pop_back(); }), HasSubstr("the conditions"));
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.prescribed.x.clear(); }), HasSubstr("prescribed"));
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.force.x = {1.0}; }), HasSubstr("the force"));
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.extent = {1, 12}; }), HasSubstr("at least 2 x 2"));
  EXPECT_THROW((void)ElementRule::plane_stress(0.6), InputError);
  EXPECT_THROW((void)ElementRule::plane_stress(-1.0), InputError);
  EXPECT_THROW((void)ElementRule::plane_stress(std::nan("")), InputError);
}

TEST(FiniteElements, ARuleWithoutStiffnessIsRefused) {
  ElasticProblem problem = clamped_sheet({5, 5}, affine_fields[1]);
  problem.force = ReferenceField(problem.extent, 1.0);
  ElementRule rule = ElementRule::plane_stress(0.3);
  rule.elasticity.setZero();
  EXPECT_THROW((void)solve_finite_elements(problem, rule), InputError);
}

} // namespace
} // namespace hdmbench
