#include "reference/sparse_solver.hpp"

#include <Eigen/IterativeLinearSolvers>
#ifdef HDMBENCH_SUITESPARSE
#include <Eigen/CholmodSupport>
#include <Eigen/UmfPackSupport>
#else
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#endif

namespace hdmbench {

namespace {

/// A factorisation of a singular matrix need not fail; its solution does not solve the system. 1e-8 is far
/// above the rounding of any matrix here (below 1e-12) and far below what is left of a right side that a
/// singular matrix cannot reach.
constexpr double accepted_residual = 1e-8;

/// `whole`: the matrix to multiply by, of which `matrix` may be a triangle.
template <typename Factorisation, typename Whole>
std::optional<Eigen::VectorXd> solve(Factorisation& factorisation, const SparseMatrix& matrix,
                                     const Eigen::VectorXd& right_side, const Whole& whole) {
  if (matrix.rows() == 0) { // everything is prescribed; SuiteSparse would fall over it
    return Eigen::VectorXd();
  }
  factorisation.compute(matrix);
  if (factorisation.info() != Eigen::Success) {
    return std::nullopt;
  }
  Eigen::VectorXd solution = factorisation.solve(right_side);
  if (factorisation.info() != Eigen::Success || !solution.allFinite() ||
      !((whole * solution - right_side).norm() <= accepted_residual * right_side.norm())) {
    return std::nullopt;
  }
  return solution;
}

} // namespace

std::optional<Eigen::VectorXd> solve_symmetric(const SparseMatrix& lower, const Eigen::VectorXd& right_side) {
#ifdef HDMBENCH_SUITESPARSE
  Eigen::CholmodSupernodalLLT<SparseMatrix, Eigen::Lower> factorisation;
  factorisation.cholmod().print = 0; // it would print "not positive definite" itself
#else
  Eigen::SimplicialLLT<SparseMatrix, Eigen::Lower, Eigen::AMDOrdering<std::int64_t>> factorisation;
#endif
  return solve(factorisation, lower, right_side, lower.selfadjointView<Eigen::Lower>());
}

std::optional<Eigen::VectorXd> solve_general(const SparseMatrix& matrix, const Eigen::VectorXd& right_side) {
#ifdef HDMBENCH_SUITESPARSE
  Eigen::UmfPackLU<SparseMatrix> factorisation;
#else
  Eigen::SparseLU<SparseMatrix, Eigen::COLAMDOrdering<std::int64_t>> factorisation;
#endif
  return solve(factorisation, matrix, right_side, matrix);
}

std::optional<Eigen::VectorXd> solve_without_factors(const SparseMatrix& matrix,
                                                     const Eigen::VectorXd& right_side) {
  Eigen::BiCGSTAB<SparseMatrix> gradients;
  gradients.setTolerance(1e-13);
  return solve(gradients, matrix, right_side, matrix);
}

} // namespace hdmbench
