#include "kernels/data/input_error.hpp"
#include "reference/sparse_solver.hpp"

#include <gtest/gtest.h>

#include <random>

namespace hdmbench {
namespace {

class SparseSolverTest : public testing::TestWithParam<SparseSolver> {
protected:
  void SetUp() override {
    if (!is_available(GetParam())) {
      GTEST_SKIP() << "this build has no " << name_of(GetParam());
    }
  }
};

/// Springs of random stiffness between all pairs of ten points; `ground` holds each of them in place. Without
/// it the matrix is singular. Tilted: not symmetric, rows still sum to `ground`.
Eigen::MatrixXd springs(unsigned seed, double ground, bool tilted) {
  constexpr int count = 10;
  std::mt19937 engine(seed);
  const auto uniform = [&] { return static_cast<double>(engine() >> 5) * 0x1p-27; };
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < i; ++j) {
      matrix(i, j) = -uniform();
      matrix(j, i) = matrix(i, j) * (tilted ? 0.5 + uniform() : 1.0);
    }
  }
  for (int i = 0; i < count; ++i) {
    matrix(i, i) = ground - matrix.row(i).sum();
  }
  return matrix;
}

SparseMatrix sparse(const Eigen::MatrixXd& dense) {
  return dense.sparseView().cast<double>();
}

SparseMatrix lower(const Eigen::MatrixXd& dense) {
  return sparse(dense.triangularView<Eigen::Lower>());
}

TEST_P(SparseSolverTest, SolvesRegularSystems) {
  const Eigen::VectorXd truth = Eigen::VectorXd::LinSpaced(10, -3.0, 5.0);
  const Eigen::MatrixXd symmetric = springs(1, 0.1, false);
  const auto a = solve_symmetric(lower(symmetric), symmetric * truth, GetParam());
  ASSERT_TRUE(a);
  EXPECT_LT((*a - truth).norm(), 1e-12);
  const Eigen::MatrixXd general = springs(2, 0.1, true);
  const auto b = solve_general(sparse(general), general * truth, GetParam());
  ASSERT_TRUE(b);
  EXPECT_LT((*b - truth).norm(), 1e-12);
}

TEST_P(SparseSolverTest, ASystemWithoutUnknownsIsSolved) {
  const auto symmetric = solve_symmetric(SparseMatrix(0, 0), Eigen::VectorXd(), GetParam());
  const auto general = solve_general(SparseMatrix(0, 0), Eigen::VectorXd(), GetParam());
  ASSERT_TRUE(symmetric);
  ASSERT_TRUE(general);
  EXPECT_EQ(symmetric->size() + general->size(), 0);
}

TEST_P(SparseSolverTest, SingularSystemsHaveNoSolutionEvenWhereTheFactorisationSucceeds) {
  const Eigen::VectorXd right_side = Eigen::VectorXd::Ones(10); // a net force on what nothing holds
  for (unsigned seed = 0; seed < 50; ++seed) {
    EXPECT_FALSE(solve_symmetric(lower(springs(seed, 0.0, false)), right_side, GetParam())) << seed;
    EXPECT_FALSE(solve_general(sparse(springs(seed, 0.0, true)), right_side, GetParam())) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(All, SparseSolverTest,
                         testing::Values(SparseSolver::suitesparse, SparseSolver::eigen),
                         [](const auto& test) {
                           return test.param == SparseSolver::suitesparse ? "suitesparse" : "eigen";
                         });

TEST(SparseSolver, WhatIsNotInThisBuildIsRefused) {
  EXPECT_TRUE(is_available(default_sparse_solver()));
  if (is_available(SparseSolver::suitesparse)) {
    GTEST_SKIP() << "this build has both";
  }
  EXPECT_THROW((void)solve_general(sparse(springs(1, 0.1, true)), Eigen::VectorXd::Ones(10),
                                   SparseSolver::suitesparse),
               InputError);
}

} // namespace
} // namespace hdmbench
