// The closed form of a round inclusion by its own equations, before `continuum` judges finite elements by it.

#include "harness/judge/truths.hpp"
#include "reference/round_inclusion.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace hdmbench {
namespace {

using Parameters = RoundInclusion::Parameters;

constexpr double radius = 7.0;

std::vector<Parameters> all_parameters() {
  std::vector<Parameters> all;
  for (const std::size_t axes : {std::size_t{2}, std::size_t{3}}) {
    for (const double contrast : {0.1, 1.0, 3.0, 10.0, 100.0}) {
      for (const double poisson : {-0.4, 0.0, 0.3, axes == 2 ? 0.5 : 0.49}) {
        all.push_back({.radius = radius,
                       .modulus_inside = 20.0 * contrast,
                       .modulus_outside = 20.0,
                       .poisson = poisson,
                       .stretch = 0.1,
                       .axes = axes});
      }
    }
  }
  return all;
}

std::vector<Point> points(std::size_t axes, int count) {
  std::mt19937_64 engine(16);
  std::vector<Point> result(static_cast<std::size_t>(count));
  for (Point& at : result) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      at[axis] = 40.0 * (static_cast<double>(engine() >> 11) * 0x1p-53 - 0.5);
    }
  }
  return result;
}

double length(const Point& at) {
  return std::hypot(at[0], at[1], at[2]);
}

/// What `call` gives, derived by an axis, central differences.
template <typename Call>
double slope(const Call& call, Point at, std::size_t axis) {
  const double h = 2e-3;
  at[axis] += h;
  const double above = call(at);
  at[axis] -= 2.0 * h;
  return (above - call(at)) / (2.0 * h);
}

/// Hooke's stress of the displacement's strain, MPa.
double stress(const Parameters& of, const Point& at, std::size_t row, std::size_t column) {
  const RoundInclusion truth(of);
  const auto by = [&](std::size_t component, std::size_t axis) {
    return slope([&](const Point& x) { return truth.displacement(x)[component]; }, at, axis);
  };
  const double nu = of.poisson;
  double spread = 0.0;
  for (std::size_t axis = 0; axis < of.axes && row == column; ++axis) {
    spread += nu / ((1.0 + nu) * (1.0 - (static_cast<double>(of.axes) - 1.0) * nu)) * by(axis, axis);
  }
  return truth.modulus(at) * (spread + (by(row, column) + by(column, row)) / (2.0 * (1.0 + nu)));
}

TEST(RoundInclusion, StressIsInBalance) {
  for (const Parameters& of : all_parameters()) {
    for (const Point& at : points(of.axes, 20)) {
      for (std::size_t row = 0; row < of.axes && std::abs(length(at) - radius) > 0.1; ++row) {
        double sum = 0.0;
        for (std::size_t axis = 0; axis < of.axes; ++axis) {
          sum += slope([&](const Point& x) { return stress(of, x, row, axis); }, at, axis);
        }
        EXPECT_LT(std::abs(sum), 1e-5) << of.axes << " axes, nu " << of.poisson; // MPa per pixel
      }
    }
  }
}

/// Inside the strain is uniform, so that the traction just inside is that at any place inside; outside it is
/// taken a little off the surface, where it has changed by that little.
TEST(RoundInclusion, BothSidesMoveAndPullAlike) {
  for (const Parameters& of : all_parameters()) {
    const RoundInclusion truth(of);
    for (Point normal : points(of.axes, 20)) {
      const double far = length(normal);
      std::ranges::transform(normal, normal.begin(), [far](double part) { return part / far; });
      const auto at = [&](double share) {
        Point result = normal;
        std::ranges::transform(result, result.begin(), [&](double part) { return part * radius * share; });
        return result;
      };
      const auto traction = [&](double share, std::size_t row) {
        double sum = 0.0;
        for (std::size_t axis = 0; axis < of.axes; ++axis) {
          sum += stress(of, at(share), row, axis) * normal[axis];
        }
        return sum;
      };
      for (std::size_t axis = 0; axis < of.axes; ++axis) {
        EXPECT_NEAR(truth.displacement(at(1.0 - 1e-12))[axis], truth.displacement(at(1.0 + 1e-12))[axis],
                    1e-10);
        // Extrapolated to the surface from two places outside it.
        const double outside = 2.0 * traction(1.001, axis) - traction(1.002, axis);
        EXPECT_NEAR(traction(0.5, axis), outside, 1e-4) << of.axes << " axes, nu " << of.poisson; // MPa
      }
    }
  }
}

/// Sheets and bodies of staircases come nearer to the round inclusion with finer pixels.
TEST(RoundInclusion, FiniteElementsConvergeToIt) {
  for (const std::size_t axes : {std::size_t{2}, std::size_t{3}}) {
    double before = 1e9;
    for (const int side : {9, 17, 33}) {
      const ElasticProblem exact = RoundInclusion({.radius = 0.25 * (side - 1),
                                                   .modulus_inside = 100.0,
                                                   .modulus_outside = 1.0,
                                                   .stretch = 1.0 / (side - 1),
                                                   .axes = axes})
                                       .on_sites(side);
      const ElementRule rule = ElementRule::of(exact.extent, 0.3);
      const double error =
          rmsd(solve_finite_elements_iteratively(exact, rule, 1e-8).displacement, exact.prescribed);
      EXPECT_LT(error, 0.8 * before);
      before = error;
    }
    EXPECT_LT(before, 0.01); // pixels, of a stretch by 1
  }
}

} // namespace
} // namespace hdmbench
