// The closed form of a round inclusion by its own equations, before `continuum` judges finite elements by it.

#include "reference/circular_inclusion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

namespace hdmbench {
namespace {

using Complex = std::complex<double>;
using Parameters = CircularInclusion::Parameters;

constexpr double radius = 7.0;

Parameters of(double contrast, double poisson) {
  return {.radius = radius,
          .modulus_inside = 20.0 * contrast,
          .modulus_outside = 20.0,
          .poisson = poisson,
          .stretch = 0.1};
}

std::vector<Parameters> all_parameters() {
  std::vector<Parameters> all;
  for (const double contrast : {0.1, 1.0, 3.0, 10.0, 100.0}) {
    for (const double poisson : {-0.4, 0.0, 0.3, 0.5}) {
      all.push_back(of(contrast, poisson));
    }
  }
  return all;
}

/// Points on both sides, none nearer than a tenth of a pixel to the circle.
std::vector<Complex> points() {
  std::mt19937_64 engine(16);
  std::vector<Complex> result;
  while (result.size() < 40) {
    const auto uniform = [&] { return 40.0 * (static_cast<double>(engine() >> 11) * 0x1p-53 - 0.5); };
    const Complex z(uniform(), uniform());
    if (std::abs(std::abs(z) - radius) > 0.1) {
      result.push_back(z);
    }
  }
  return result;
}

/// Derivative by x (direction 1) or y (direction i) of what a call gives, central differences.
template <typename Call>
auto slope(Call&& call, Complex z, Complex direction) {
  const double h = 1e-4;
  return (call(z + h * direction) - call(z - h * direction)) / (2.0 * h);
}

const Complex along_x(1.0, 0.0);
const Complex along_y(0.0, 1.0);

/// How far the stress is from what Hooke makes of the displacement's strain, MPa.
double hooke_error(const CircularInclusion& truth, const Parameters& parameters, Complex z) {
  const auto displacement = [&](Complex at) { return truth.displacement(at); };
  const Complex by_x = slope(displacement, z, along_x);
  const Complex by_y = slope(displacement, z, along_y);
  const double modulus = truth.is_inside(z) ? parameters.modulus_inside : parameters.modulus_outside;
  const double nu = parameters.poisson;
  const double plane = modulus / (1.0 - nu * nu);
  const double xx = plane * (by_x.real() + nu * by_y.imag());
  const double yy = plane * (by_y.imag() + nu * by_x.real());
  const double xy = modulus / (2.0 * (1.0 + nu)) * (by_x.imag() + by_y.real());
  const auto stress = truth.stress(z);
  return std::max({std::abs(stress.xx - xx), std::abs(stress.yy - yy), std::abs(stress.xy - xy)});
}

/// Divergence of the stress, MPa per pixel.
double imbalance(const CircularInclusion& truth, Complex z) {
  const auto part = [&](double CircularInclusion::Stress::*component, Complex direction) {
    return slope([&](Complex at) { return truth.stress(at).*component; }, z, direction);
  };
  using Stress = CircularInclusion::Stress;
  return std::max(std::abs(part(&Stress::xx, along_x) + part(&Stress::xy, along_y)),
                  std::abs(part(&Stress::xy, along_x) + part(&Stress::yy, along_y)));
}

/// Jump over the circle of displacement (pixels) and traction (MPa) at an angle.
double jump(const CircularInclusion& truth, double angle) {
  const Complex normal = std::polar(1.0, angle);
  const auto traction = [&](Complex z) {
    const auto stress = truth.stress(z);
    return Complex(stress.xx * normal.real() + stress.xy * normal.imag(),
                   stress.xy * normal.real() + stress.yy * normal.imag());
  };
  const Complex within = normal * (radius * (1.0 - 1e-12));
  const Complex beyond = normal * (radius * (1.0 + 1e-12));
  EXPECT_TRUE(truth.is_inside(within) && !truth.is_inside(beyond));
  return std::max(std::abs(truth.displacement(beyond) - truth.displacement(within)),
                  std::abs(traction(beyond) - traction(within)));
}

TEST(CircularInclusion, StressFollowsFromTheDisplacementAndIsInBalance) {
  for (const Parameters& parameters : all_parameters()) {
    const CircularInclusion truth(parameters);
    for (const Complex z : points()) {
      EXPECT_LT(hooke_error(truth, parameters, z), 1e-6 * std::max(1.0, parameters.modulus_inside));
      EXPECT_LT(imbalance(truth, z), 1e-6);
    }
  }
}

TEST(CircularInclusion, BothSidesOfTheCircleMoveAndPullAlike) {
  for (const Parameters& parameters : all_parameters()) {
    const CircularInclusion truth(parameters);
    for (int i = 0; i < 24; ++i) {
      EXPECT_LT(jump(truth, 0.1 + i * std::numbers::pi / 12.0), 1e-9)
          << "moduli " << parameters.modulus_inside << ", nu " << parameters.poisson;
    }
  }
}

} // namespace
} // namespace hdmbench
