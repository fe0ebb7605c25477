#include "reference/elastic_krylov.hpp"

#include "harness/judge/truths.hpp"
#include "kernels/data/input_error.hpp"
#include "test/elastic_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

namespace hdmbench {
namespace {

using namespace test;

// A random sheet held at its border, whose inside is free.
ElasticProblem sheet() {
  ElasticProblem problem = clamped_sheet({33, 27}, [](double x, double y) {
    return Vector{0.1 * x * y, 0.01 * x * x - 0.3 * y};
  });
  problem.modulus = random_sheet(problem.extent).modulus;
  return problem;
}

/// Returns how far the solution is from the direct one, pixels, at the smallest tolerance.
template <typename Solve>
double meet_the_direct_solution(const Solve& solve) {
  const ElasticProblem problem = sheet();
  double last = 0.0;
  for (const double nu : {0.0, 0.3}) {
    const ElementRule rule = ElementRule::plane_stress(nu);
    const ReferenceField direct = solve_finite_elements(problem, rule);
    double before = 1e9;
    for (const double tolerance : {1e-2, 1e-5, 1e-10}) {
      const IterativeSolution found = solve(problem, rule, tolerance);
      EXPECT_GT(found.iterations, 0);
      const double apart = rmsd(found.displacement, direct);
      EXPECT_LT(apart, 0.1 * before) << "a smaller tolerance must come nearer";
      before = apart;
    }
    last = std::max(last, before);
  }
  return last;
}

TEST(ElasticKrylov, MeetsTheDirectSolutionToItsTolerance) {
  const double apart = meet_the_direct_solution([](const auto& problem, const auto& rule, double tolerance) {
    IterativeSolution found = solve_finite_elements_iteratively(problem, rule, tolerance);
    EXPECT_LE(found.residual, 1.001 * tolerance);
    // Displacements are up to 80 px; a smooth error of 4 % of them has forces of 1 % of the right side.
    EXPECT_LT(rmsd(found.displacement, solve_finite_elements(problem, rule)), 300.0 * tolerance);
    return found;
  });
  EXPECT_LT(apart, 1e-7); // pixels
}

TEST(ElasticKrylov, AnotherMatrixIsSeen) {
  ElasticProblem problem = sheet();
  const ElementRule rule = ElementRule::plane_stress(0.3);
  const ReferenceField direct = solve_finite_elements(problem, rule);
  problem.modulus[problem.modulus.size() / 2] *= 10.0;
  EXPECT_GT(rmsd(solve_finite_elements_iteratively(problem, rule, 1e-10).displacement, direct), 1e-4);
}

TEST(ElasticKrylov, WhatIsPrescribedStaysAsItIs) {
  ElasticProblem problem = sheet();
  std::ranges::fill(problem.fixed_x, std::uint8_t{1});
  std::ranges::fill(problem.fixed_y, std::uint8_t{1});
  const IterativeSolution found =
      solve_finite_elements_iteratively(problem, ElementRule::plane_stress(0.3), 1e-6);
  EXPECT_EQ(found.displacement.x, problem.prescribed.x);
  EXPECT_EQ(found.iterations, 0);
}

TEST(ElasticKrylov, RefusesWhatItCannotReach) {
  const ElasticProblem problem = sheet();
  const ElementRule rule = ElementRule::plane_stress(0.3);
  for (const double tolerance : {0.0, 1.0, -1.0, std::nan("")}) {
    EXPECT_THROW((void)solve_finite_elements_iteratively(problem, rule, tolerance), InputError) << tolerance;
  }
  EXPECT_THROW((void)solve_finite_elements_iteratively(problem, rule, 1e-10, 1), InputError);
}

TEST(AlgebraicMultigrid, MeetsTheDirectSolutionToItsTolerance) {
  if (!has_algebraic_multigrid()) {
    GTEST_SKIP() << "built without -DHDMBENCH_PETSC=ON";
  }
  EXPECT_LT(meet_the_direct_solution(solve_finite_elements_by_multigrid), 1e-7); // pixels
}

TEST(AlgebraicMultigrid, SaysWhatItCannotDo) {
  const ElasticProblem problem = sheet();
  const ElementRule rule = ElementRule::plane_stress(0.3);
  const auto solve = [&](double tolerance) {
    (void)solve_finite_elements_by_multigrid(problem, rule, tolerance);
  };
  if (has_algebraic_multigrid()) {
    EXPECT_THROW(solve(0.0), InputError);
    EXPECT_THROW(solve(1.0), InputError);
    return;
  }
  try {
    solve(1e-6);
    FAIL() << "there is nothing to solve it with";
  } catch (const InputError& error) {
    EXPECT_NE(std::string_view(error.what()).find("HDMBENCH_PETSC"), std::string_view::npos) << error.what();
  }
}

} // namespace
} // namespace hdmbench
