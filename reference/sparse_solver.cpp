#include "reference/sparse_solver.hpp"

#include "kernels/data/input_error.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#ifdef HDMBENCH_SUITESPARSE
#include <Eigen/CholmodSupport>
#include <Eigen/UmfPackSupport>
#endif

namespace hdmbench {

namespace {

/// A factorisation of a singular matrix need not fail; its solution does not solve the system. 1e-8 is far
/// above the rounding of any matrix here (below 1e-12) and far below what is left of a right side that a
/// singular matrix cannot reach.
constexpr double accepted_residual = 1e-8;

template <typename Factorisation, typename Product>
std::optional<Eigen::VectorXd> solve(Factorisation& factorisation, const SparseMatrix& matrix,
                                     const Eigen::VectorXd& right_side, Product product) {
  if (matrix.rows() == 0) { // everything is prescribed; SuiteSparse would fall over it
    return Eigen::VectorXd();
  }
  factorisation.compute(matrix);
  if (factorisation.info() != Eigen::Success) {
    return std::nullopt;
  }
  Eigen::VectorXd solution = factorisation.solve(right_side);
  if (factorisation.info() != Eigen::Success || !solution.allFinite() ||
      !((product(solution) - right_side).norm() <= accepted_residual * right_side.norm())) {
    return std::nullopt;
  }
  return solution;
}

[[noreturn, maybe_unused]] void refuse_suitesparse() {
  throw InputError("this build has no CHOLMOD and UMFPACK: configure it with -DHDMBENCH_SUITESPARSE=ON");
}

} // namespace

bool is_available([[maybe_unused]] SparseSolver solver) {
#ifdef HDMBENCH_SUITESPARSE
  return true;
#else
  return solver == SparseSolver::eigen;
#endif
}

SparseSolver default_sparse_solver() {
  return is_available(SparseSolver::suitesparse) ? SparseSolver::suitesparse : SparseSolver::eigen;
}

std::string_view name_of(SparseSolver solver) {
  return solver == SparseSolver::suitesparse ? "CHOLMOD and UMFPACK" : "Eigen";
}

std::optional<Eigen::VectorXd> solve_symmetric(const SparseMatrix& lower, const Eigen::VectorXd& right_side,
                                               SparseSolver solver) {
  const auto product = [&](const Eigen::VectorXd& solution) -> Eigen::VectorXd {
    return lower.selfadjointView<Eigen::Lower>() * solution;
  };
  if (solver == SparseSolver::eigen) {
    Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::AMDOrdering<std::int64_t>> factorisation;
    return solve(factorisation, lower, right_side, product);
  }
#ifdef HDMBENCH_SUITESPARSE
  Eigen::CholmodSupernodalLLT<SparseMatrix, Eigen::Lower> factorisation;
  factorisation.cholmod().print = 0; // it would print "not positive definite" itself
  return solve(factorisation, lower, right_side, product);
#else
  refuse_suitesparse();
#endif
}

std::optional<Eigen::VectorXd> solve_general(const SparseMatrix& matrix, const Eigen::VectorXd& right_side,
                                             SparseSolver solver) {
  const auto product = [&](const Eigen::VectorXd& solution) -> Eigen::VectorXd { return matrix * solution; };
  if (solver == SparseSolver::eigen) {
    Eigen::SparseLU<SparseMatrix, Eigen::COLAMDOrdering<std::int64_t>> factorisation;
    return solve(factorisation, matrix, right_side, product);
  }
#ifdef HDMBENCH_SUITESPARSE
  Eigen::UmfPackLU<SparseMatrix> factorisation;
  return solve(factorisation, matrix, right_side, product);
#else
  refuse_suitesparse();
#endif
}

} // namespace hdmbench
