#include "harness/judge/truths.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/finite_elements.hpp"
#include "test/elastic_checks.hpp"
#include "test/files.hpp"
#include "test/random_level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace hdmbench {
namespace {

using namespace test;
using testing::HasSubstr;

// Checks as functions that return an error figure, so that each can be shown to fail on a planted mistake.

double largest_difference(const ReferenceField& a, const ReferenceField& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a[0].size(); ++i) {
    largest = std::max({largest, std::abs(a[0][i] - b[0][i]), std::abs(a[1][i] - b[1][i])});
  }
  return largest;
}

const std::vector<Displacement> affine_fields{
    [](double, double) {
      return Vector{3.0, -2.0};
    },
    [](double x, double y) {
      return Vector{0.1 * x, -0.2 * y};
    },
    [](double x, double y) {
      return Vector{0.3 * y, 0.3 * x};
    },
    [](double x, double y) {
      return Vector{1.0 - 0.2 * y, -4.0 + 0.2 * x};
    },
    [](double x, double y) {
      return Vector{0.5 - 0.7 * x + 0.2 * y, 1.0 + 0.4 * x + 0.9 * y};
    },
};

/// Patch test, pixels. `soft_pixel`: the modulus of one pixel amid 1.
double patch_error(const ElementRule& rule, double soft_pixel = 1.0) {
  double largest = 0.0;
  for (const Extent extent : {Extent{5, 5}, Extent{9, 4}, Extent{3, 11}}) {
    for (const Displacement& affine : affine_fields) {
      ElasticProblem problem = clamped_sheet(extent, affine);
      problem.modulus[extent.index(1, 1)] = soft_pixel;
      largest =
          std::max(largest, largest_difference(solve_finite_elements(problem, rule), problem.prescribed));
    }
  }
  return largest;
}

/// A smooth displacement, period 2 L in both directions, and the plane stress it causes.
struct Manufactured {
  double nu;
  double side; ///< L, pixels
  bool varying_modulus;

  [[nodiscard]] double modulus(double x, double y) const {
    return varying_modulus ? 20.0 * (1.0 + 0.5 * std::sin(3.0 * x / side) * std::cos(2.0 * y / side)) : 20.0;
  }
  [[nodiscard]] Vector displacement(double x, double y) const {
    const double a = std::numbers::pi * x / side;
    const double b = std::numbers::pi * y / side;
    return {std::sin(a) * std::cos(0.5 * b), std::cos(0.7 * a) * std::sin(1.3 * b)};
  }
  struct Stress {
    double xx;
    double yy;
    double xy;
  };
  [[nodiscard]] Stress stress(double x, double y) const {
    const double w = std::numbers::pi / side;
    const double a = w * x;
    const double b = w * y;
    const double strain_xx = w * std::cos(a) * std::cos(0.5 * b);
    const double strain_yy = 1.3 * w * std::cos(0.7 * a) * std::cos(1.3 * b);
    const double shear =
        -0.5 * w * std::sin(a) * std::sin(0.5 * b) - 0.7 * w * std::sin(0.7 * a) * std::sin(1.3 * b);
    const double plane = modulus(x, y) / (1.0 - nu * nu);
    return {plane * (strain_xx + nu * strain_yy), plane * (strain_yy + nu * strain_xx),
            modulus(x, y) / (2.0 * (1.0 + nu)) * shear};
  }
  /// Body force that holds the stress in balance, from central differences (error far below the mesh's).
  [[nodiscard]] Vector force(double x, double y) const {
    const double h = 1e-4 * side;
    const auto slope = [&](double Stress::*part, double dx, double dy) {
      return (stress(x + dx * h, y + dy * h).*part - stress(x - dx * h, y - dy * h).*part) / (2.0 * h);
    };
    return {-slope(&Stress::xx, 1, 0) - slope(&Stress::xy, 0, 1),
            -slope(&Stress::xy, 1, 0) - slope(&Stress::yy, 0, 1)};
  }
};

/// Root mean square error in pixels (amplitude 1) on n x n nodes.
double manufactured_error(const ElementRule& rule, double nu, int n, bool varying_modulus = false) {
  const Manufactured truth{.nu = nu, .side = n - 1.0, .varying_modulus = varying_modulus};
  const auto displacement = [&](double x, double y) { return truth.displacement(x, y); };
  ElasticProblem problem = clamped_sheet({n, n}, displacement);
  problem.force = sampled({n, n}, [&](double x, double y) { return truth.force(x, y); });
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      problem.modulus[problem.extent.index(x, y)] = truth.modulus(x, y);
    }
  }
  return rmsd(solve_finite_elements(problem, rule), problem.prescribed);
}

/// The lowest order observed from mesh to finer mesh: 2 for bilinear elements.
double observed_order(const ElementRule& rule, double nu, bool varying_modulus = false) {
  double lowest = 10.0;
  double coarser = manufactured_error(rule, nu, 9, varying_modulus);
  for (const int n : {17, 33, 65}) {
    const double finer = manufactured_error(rule, nu, n, varying_modulus);
    lowest = std::min(lowest, std::log2(coarser / finer));
    coarser = finer;
  }
  return lowest;
}

/// Twice the energies of stretch, shear and bending of a sheet against their closed forms, relative.
double energy_error(const ElementRule& rule, double nu) {
  const double modulus = 7.0;
  const Extent extent{6, 4};
  const double area = 5.0 * 3.0;
  const double plane = modulus / (1.0 - nu * nu);
  const double shear = modulus / (2.0 * (1.0 + nu));
  struct Case {
    Displacement displacement;
    double expected;
  };
  // Bending in x * y: strain xx = y and shear x; the means of x^2 and y^2 over the sheet are 25/3 and 9/3.
  const std::vector<Case> cases{
      {[](double x, double) {
         return Vector{0.1 * x, 0.0};
       },
       plane * 0.01 * area},
      {[](double x, double y) {
         return Vector{0.1 * x, 0.2 * y};
       },
       plane * (0.01 + 0.04 + 2.0 * nu * 0.02) * area},
      {[](double, double y) {
         return Vector{0.1 * y, 0.0};
       },
       shear * 0.01 * area},
      {[](double x, double y) {
         return Vector{x * y, 0.0};
       },
       (plane * 9.0 / 3.0 + shear * 25.0 / 3.0) * area},
  };
  const ElasticProblem problem = clamped_sheet(extent, affine_fields[0], modulus);
  double largest = 0.0;
  for (const Case& c : cases) {
    const double energy = elastic_energy(problem, rule, sampled(extent, c.displacement));
    largest = std::max(largest, std::abs(energy / c.expected - 1.0));
  }
  return largest;
}

ElasticProblem random_sheet(Extent extent) {
  ElasticProblem problem = elastic_problem(random_problem(extent, Texture::smooth, 7).level);
  problem.fixed_x[0] = problem.fixed_y[0] = problem.fixed_x.back() = problem.fixed_y.back() = 1;
  return problem;
}

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

TEST(FiniteElements, EnergiesAreTheClosedForms) {
  for (const double nu : {0.0, 0.3, 0.5}) {
    EXPECT_LT(energy_error(ElementRule::plane_stress(nu), nu), 1e-13);
  }
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
  level.target[0] = {0.0F, 1.0F, 0.0F, 1.0F};
  level.confidence[1] = {1.0F, 1.0F, 1.0F, 1.0F};
  for (const float confidence : {0.2F, 0.5F, 0.9F}) {
    level.confidence[0] = {1.0F, confidence, 1.0F, confidence};
    set_inverse_modulus(level);
    const ReferenceField field =
        solve_finite_elements(elastic_problem(level), ElementRule::plane_stress(0.0));
    // The square resists with its modulus over its height of one pixel, half of it on each of the two sites.
    const double share = static_cast<double>(confidence);
    const double spring = share / (1.0 - share);
    EXPECT_NEAR(field[0][1], spring / (spring + 0.5), 1e-6);
  }
}

TEST(FiniteElements, ObservedComponentsAreKept) {
  Level level = random_problem({20, 15}, Texture::smooth, 3).level;
  for (auto* const confidences : {&level.confidence[0], &level.confidence[1]}) {
    std::ranges::transform(*confidences, confidences->begin(),
                           [](float confidence) { return confidence > 0.0F ? 1.0F : 0.0F; });
  }
  const ReferenceField field = solve_finite_elements(elastic_problem(level), ElementRule::plane_stress(0.3));
  int kept = 0;
  for (std::size_t i = 0; i < level.extent.sites(); ++i) {
    if (level.confidence[0][i] > 0.0F) {
      EXPECT_EQ(field[0][i], static_cast<double>(level.target[0][i]));
      ++kept;
    }
    if (level.confidence[1][i] > 0.0F) {
      EXPECT_EQ(field[1][i], static_cast<double>(level.target[1][i]));
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
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.modulus[5] = std::nan(""); }), HasSubstr("is nan MPa"));
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

/// By conjugate gradients of our own, and by PETSc's multigrid where the build has it.
TEST(FiniteElements, IterativeSolutionsMeetTheDirectOneToTheirTolerance) {
  ElasticProblem problem = clamped_sheet({33, 27}, [](double x, double y) {
    return Vector{0.1 * x * y, 0.01 * x * x - 0.3 * y};
  });
  problem.modulus = random_sheet(problem.extent).modulus;
  const ElementRule rule = ElementRule::plane_stress(0.3);
  const ReferenceField direct = solve_finite_elements(problem, rule);
  const auto expect_nearer = [&](const auto& solve) {
    double before = 1e9;
    for (const double tolerance : {1e-2, 1e-5, 1e-10}) {
      const double apart = rmsd(solve(problem, rule, tolerance).displacement, direct);
      EXPECT_LT(apart, 0.1 * before) << "a smaller tolerance must come nearer";
      before = apart;
    }
    EXPECT_LT(before, 1e-7); // pixels
    EXPECT_THROW((void)solve(problem, rule, 0.0), InputError);
    EXPECT_THROW((void)solve(problem, rule, 1.0), InputError);
  };
  expect_nearer([](const auto&... all) { return solve_finite_elements_iteratively(all...); });
  EXPECT_THROW((void)solve_finite_elements_iteratively(problem, rule, 1e-10, 1), InputError);
  if (has_algebraic_multigrid()) {
    expect_nearer(solve_finite_elements_by_multigrid);
  } else {
    EXPECT_THAT(test::refusal([&] { (void)solve_finite_elements_by_multigrid(problem, rule, 1e-6); }),
                HasSubstr("HDMBENCH_PETSC"));
  }
}

} // namespace
} // namespace hdmbench
