#include "harness/judge/truths.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/finite_elements.hpp"
#include "test/files.hpp"
#include "test/random_level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace hdmbench {
namespace {

using namespace test;
using testing::HasSubstr;

// The check by a manufactured solution returns an error figure, so that it can be shown to fail on a planted
// mistake.

using Displacement = std::function<Point(const Point&)>;

double unit_modulus(const Point&) {
  return 1.0;
}

double largest_difference(const ReferenceField& a, const ReferenceField& b) {
  double largest = 0.0;
  for (std::size_t axis = 0; axis < a.extent.axes(); ++axis) {
    for (std::size_t i = 0; i < a[axis].size(); ++i) {
      largest = std::max(largest, std::abs(a[axis][i] - b[axis][i]));
    }
  }
  return largest;
}

const std::vector<Displacement> affine_fields{
    [](const Point&) {
      return Point{3.0, -2.0, 1.0};
    },
    [](const Point& at) {
      return Point{0.1 * at[0], -0.2 * at[1], 0.15 * at[2]};
    },
    [](const Point& at) {
      return Point{0.3 * at[1], 0.3 * at[0] - 0.2 * at[2], -0.2 * at[1]};
    },
    [](const Point& at) {
      return Point{1.0 - 0.2 * at[1] + 0.1 * at[2], -4.0 + 0.2 * at[0] - 0.3 * at[2],
                   2.0 - 0.1 * at[0] + 0.3 * at[1]};
    },
    [](const Point& at) {
      return Point{0.5 - 0.7 * at[0] + 0.2 * at[1] - 0.1 * at[2], 1.0 + 0.4 * at[0] + 0.9 * at[1],
                   0.3 * at[0] - 0.5 * at[1] + 0.2 * at[2]};
    },
};

/// Patch test, pixels. `soft_site`: the modulus of one site amid 1.
double patch_error(Extent extent, const ElasticModel& model, double soft_site = 1.0) {
  double largest = 0.0;
  for (const Displacement& affine : affine_fields) {
    ElasticProblem problem = clamped_body(extent, unit_modulus, affine);
    problem.modulus[extent.index(1, 1, extent.axes() == 2 ? 0 : 1)] = soft_site;
    largest =
        std::max(largest, largest_difference(solve_finite_elements(problem, ElementRule::of(extent, model)),
                                             problem.prescribed));
  }
  return largest;
}

double lame_of(std::size_t axes, double nu) { // of modulus 1
  return axes == 2 ? nu / (1.0 - nu * nu) : nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
}

/// A smooth displacement, period 2 L in every direction, and the load that it takes.
struct Manufactured {
  std::size_t axes;
  double nu;
  double side; ///< L, pixels
  bool varying_modulus;

  [[nodiscard]] double modulus(const Point& at) const {
    const double wave = std::sin(3.0 * at[0] / side) * std::cos((2.0 * at[1] + at[2]) / side);
    return varying_modulus ? 20.0 * (1.0 + 0.5 * wave) : 20.0;
  }
  [[nodiscard]] Point displacement(const Point& at) const {
    const double a = std::numbers::pi * at[0] / side;
    const double b = std::numbers::pi * at[1] / side;
    const double c = std::numbers::pi * at[2] / side;
    return {std::sin(a) * std::cos(0.5 * b) * std::cos(0.6 * c),
            std::cos(0.7 * a) * std::sin(1.3 * b) * std::cos(0.4 * c),
            std::cos(0.8 * a) * std::cos(0.5 * b) * std::sin(c)};
  }
  /// What `call` gives, derived by an axis, by central differences (error far below the mesh's).
  template <typename Call>
  [[nodiscard]] double slope(const Call& call, Point at, std::size_t axis) const {
    const double h = 3e-4 * side;
    at[axis] += h;
    const double above = call(at);
    at[axis] -= 2.0 * h;
    return (above - call(at)) / (2.0 * h);
  }
  [[nodiscard]] double stress(const Point& at, std::size_t row, std::size_t column) const {
    const auto by = [&](std::size_t component, std::size_t axis) {
      return slope([&](const Point& x) { return displacement(x)[component]; }, at, axis);
    };
    double spread = 0.0;
    for (std::size_t axis = 0; axis < axes && row == column; ++axis) {
      spread += lame_of(axes, nu) * by(axis, axis);
    }
    return modulus(at) * (spread + (by(row, column) + by(column, row)) / (2.0 * (1.0 + nu)));
  }
  /// Body force that holds the stress in balance.
  [[nodiscard]] double force(const Point& at, std::size_t row) const {
    double sum = 0.0;
    for (std::size_t axis = 0; axis < axes; ++axis) {
      sum -= slope([&](const Point& x) { return stress(x, row, axis); }, at, axis);
    }
    return sum;
  }
};

/// Root mean square error in pixels (amplitude 1) on n nodes a side.
double manufactured_error(const ElementRule& rule, double nu, int n, bool varying_modulus = false) {
  const bool flat = rule.elasticity.rows() == 3;
  const Extent extent{n, n, flat ? 1 : n};
  const Manufactured truth{
      .axes = extent.axes(), .nu = nu, .side = n - 1.0, .varying_modulus = varying_modulus};
  ElasticProblem problem = clamped_body(
      extent, [&](const Point& at) { return truth.modulus(at); },
      [&](const Point& at) { return truth.displacement(at); });
  problem.force = ReferenceField(extent);
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      problem.force[axis][site] = truth.force(place(extent, site), axis);
    }
  }
  return rmsd(solve_finite_elements_iteratively(problem, rule, 1e-8).displacement, problem.prescribed);
}

/// The lowest order observed from mesh to finer mesh: 2 for bilinear and trilinear elements.
double observed_order(const ElementRule& rule, double nu, int finest, bool varying_modulus = false) {
  double lowest = 10.0;
  double coarser = manufactured_error(rule, nu, 9, varying_modulus);
  for (int n = 17; n <= finest; n = 2 * n - 1) {
    const double finer = manufactured_error(rule, nu, n, varying_modulus);
    lowest = std::min(lowest, std::log2(coarser / finer));
    coarser = finer;
  }
  return lowest;
}

constexpr Extent small_sheet{6, 4};
constexpr Extent small_block{6, 4, 3};

double random_modulus(const Point&) {
  static std::mt19937 engine(7);
  return std::pow(1000.0, static_cast<double>(engine()) * 0x1p-32);
}

TEST(FiniteElements, AffineBorderGivesTheAffineField) {
  for (const Extent extent : {Extent{5, 5}, {9, 4}, {3, 11}, {5, 4, 3}, {3, 3, 9}}) {
    for (const double nu : {-0.5, 0.0, 0.3, 0.49}) {
      EXPECT_LT(patch_error(extent, nu), 1e-10) << "nu " << nu;
      EXPECT_LT(patch_error(extent, {nu, Integration::selective_reduced}), 1e-10) << "nu " << nu;
    }
    EXPECT_GT(patch_error(extent, 0.3, 0.5), 1e-3) << "a soft site went unseen";
  }
  EXPECT_LT(patch_error({5, 5}, 0.5), 1e-10);
}

TEST(FiniteElements, ManufacturedSolutionsConvergeWithOrderTwo) {
  for (const Extent extent : {small_sheet, small_block}) {
    for (const double nu : {0.0, 0.3}) {
      const ElementRule rule = ElementRule::of(extent, nu);
      for (const bool varying_modulus : {false, true}) {
        EXPECT_GE(observed_order(rule, nu, 33, varying_modulus), 1.9)
            << "nu " << nu << (varying_modulus ? ", varying modulus" : "");
      }
    }
  }
  EXPECT_LT(manufactured_error(ElementRule::of(small_sheet, 0.3), 0.3, 65, true), 1e-3);
  for (const double nu : {0.3, 0.499}) {
    const ElementRule rule = ElementRule::of(small_block, {nu, Integration::selective_reduced});
    EXPECT_GE(observed_order(rule, nu, 17, true), 1.9) << "selective reduced integration, nu " << nu;
  }
}

TEST(FiniteElements, EveryGaussPointHasTheModulusOfItsPixel) {
  // x * y on one element, nu = 0: twice the energy is the mean of modulus (y^2 + x^2 / 2) over the points.
  for (const Extent extent : {Extent{2, 2}, {2, 2, 2}}) {
    const ElasticProblem problem =
        clamped_body(extent, random_modulus, [](const Point& at) { return Point{at[0] * at[1]}; });
    double expected = 0.0;
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      const auto near = [&](std::size_t axis) {
        return 0.5 + (place(extent, site)[axis] - 0.5) / std::sqrt(3.0);
      };
      expected += problem.modulus[site] * (near(1) * near(1) + near(0) * near(0) / 2.0) /
                  static_cast<double>(extent.sites());
    }
    EXPECT_NEAR(elastic_energy(problem, ElementRule::of(extent, 0.0), problem.prescribed), expected,
                1e-12 * expected);
  }
}

TEST(FiniteElements, PlantedMistakesFailTheChecks) {
  const double nu = 0.3;
  for (const Extent extent : {small_sheet, small_block}) {
    const ElementRule good = ElementRule::of(extent, nu);
    const auto shear_row = static_cast<Eigen::Index>(extent.axes());
    ElementRule shear = good;
    shear.elasticity(shear_row, shear_row) *= 2.0; // 1 - nu instead of (1 - nu) / 2
    ElementRule coupling = good;
    coupling.elasticity(0, 1) = coupling.elasticity(1, 0) =
        good.elasticity(0, 1) * (extent.axes() == 2 ? 1.05 : 1.2);
    ElementRule point_missing = good;
    point_missing.points.pop_back();
    ElementRule weights = good;
    for (QuadraturePoint& point : weights.points) {
      point.weight = 0.5;
    }
    for (const auto& [name, rule] :
         {std::pair{"shear", shear}, std::pair{"coupling", coupling},
          std::pair{"point missing", point_missing}, std::pair{"weights", weights}}) {
      EXPECT_LT(observed_order(rule, nu, extent.axes() == 2 ? 33 : 17), 1.0) << name;
    }
  }
}

/// A bar without any modulus to speak of against springs: each end follows its own target.
TEST(FiniteElements, ASpringSharesTheWayWithTheTissue) {
  for (const Extent extent : {Extent{2, 2}, {2, 2, 2}}) {
    Level level{.extent = extent,
                .target = VectorField(extent),
                .confidence = VectorField(extent, 1.0F),
                .modulus = ScalarField(extent, 3.0F)};
    set_inverse_modulus(level);
    for (const float confidence : {0.2F, 0.5F, 0.9F}) {
      // The left side is held, the right one pulled by 1 pixel; other components are held everywhere.
      for (std::size_t site = 1; site < extent.sites(); site += 2) {
        level.target[0][site] = 1.0F;
        level.confidence[0][site] = confidence;
      }
      const ReferenceField field =
          solve_finite_elements(elastic_problem(level), ElementRule::of(extent, 0.0));
      // The element resists with its modulus over its height of one pixel, shared by the sites on the right.
      const double share = static_cast<double>(confidence);
      const double spring = share / (1.0 - share);
      EXPECT_NEAR(field[0][1], spring / (spring + 2.0 / static_cast<double>(extent.sites())), 1e-6);
    }
  }
}

std::string refusal(const std::function<void(ElasticProblem&)>& spoil, Extent extent = {4, 3}) {
  ElasticProblem problem = clamped_body(extent, unit_modulus, affine_fields[1]);
  spoil(problem);
  return test::refusal([&] { (void)solve_finite_elements(problem, ElementRule::of(extent, 0.3)); });
}

/// Holds only these: components at sites.
auto only(std::vector<std::pair<std::size_t, std::array<int, 3>>> held) {
  return [held](ElasticProblem& problem) {
    problem.fixed = Planes<std::uint8_t>(problem.extent);
    for (const auto& [axis, at] : held) {
      problem.fixed[axis][problem.extent.index(at[0], at[1], at[2])] = 1;
    }
  };
}

TEST(FiniteElements, ABodyThatIsFreeToMoveIsRefused) {
  EXPECT_THAT(refusal(only({{1, {0, 0}}, {1, {1, 0}}})), HasSubstr("no site has a known displacement in x"));
  EXPECT_THAT(refusal(only({{0, {0, 0}}, {0, {0, 1}}})), HasSubstr("no site has a known displacement in y"));
  EXPECT_THAT(refusal(only({{0, {0, 1}}, {0, {3, 1}}, {1, {2, 0}}, {1, {2, 2}}})),
              HasSubstr("it can turn about x = 2, y = 1"));
  EXPECT_EQ(refusal(only({{0, {0, 1}}, {0, {3, 2}}, {1, {2, 0}}})), "accepted");
  EXPECT_EQ(refusal(only({{0, {0, 0}}, {0, {0, 1}}, {1, {2, 2}}})), "accepted");
  EXPECT_EQ(refusal(only({{0, {0, 1}}, {1, {2, 0}}, {1, {1, 0}}})), "accepted");
  EXPECT_EQ(refusal(only({{0, {0, 2}}, {1, {2, 0}}, {1, {1, 0}}})), "accepted");
}

TEST(FiniteElements, BadInputIsRefused) {
  EXPECT_EQ(refusal([](ElasticProblem&) {}), "accepted");
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.modulus[5] = 0.0; }), HasSubstr("x = 1, y = 1 is 0 MPa"));
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.modulus[5] = std::nan(""); }), HasSubstr("is nan MPa"));
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.extent = {1, 12}; }), HasSubstr("at least 2 x 2"));
  EXPECT_THAT(refusal([](ElasticProblem& p) { p.modulus.back() = -1.0; }, small_block),
              HasSubstr("x = 5, y = 3, z = 2 is -1 MPa"));
  for (const Extent extent : {small_sheet, small_block}) {
    EXPECT_THROW((void)ElementRule::of(extent, 0.6), InputError);
    EXPECT_THROW((void)ElementRule::of(extent, -1.0), InputError);
    EXPECT_THROW((void)ElementRule::of(extent, std::nan("")), InputError);
  }
  EXPECT_THROW((void)ElementRule::of(small_block, 0.5), InputError);
}

TEST(FiniteElements, ARuleWithoutStiffnessIsRefused) {
  ElasticProblem problem = clamped_body({5, 5}, unit_modulus, affine_fields[1]);
  problem.force = ReferenceField(problem.extent, 1.0);
  ElementRule rule = ElementRule::of(problem.extent, 0.3);
  rule.elasticity.setZero();
  EXPECT_THROW((void)solve_finite_elements(problem, rule), InputError);
}

/// By conjugate gradients of our own, and by PETSc's multigrid where the build has it.
TEST(FiniteElements, IterativeSolutionsMeetTheDirectOneToTheirTolerance) {
  for (const Extent extent : {Extent{33, 27}, {9, 8, 11}}) {
    const ElasticProblem problem = clamped_body(extent, random_modulus, [](const Point& at) {
      return Point{0.1 * at[0] * at[1], 0.01 * at[0] * at[0] - 0.3 * at[1], 0.02 * at[1] * at[2]};
    });
    const ElementRule rule = ElementRule::of(extent, 0.3);
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
}

} // namespace
} // namespace hdmbench
