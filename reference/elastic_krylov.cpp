#include "reference/elastic_krylov.hpp"

#include "kernels/data/input_error.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <fmt/format.h>

namespace hdmbench {

void require_tolerance(double tolerance) {
  if (!(tolerance > 0.0 && tolerance < 1.0)) {
    throw InputError(fmt::format("the tolerance is {}, it must be above 0 and below 1", tolerance));
  }
}

IterativeSolution solve_finite_elements_iteratively(const ElasticProblem& problem, const ElementRule& rule,
                                                    double tolerance, int most_iterations) {
  require_tolerance(tolerance);
  const ElasticSystem system = assemble(problem, rule);
  if (system.lower.rows() == 0) { // everything is prescribed
    return {.displacement = displacement_of(problem, system, system.right_side)};
  }
  // Both triangles, so that Eigen multiplies on all threads.
  const SparseMatrix matrix = system.lower.selfadjointView<Eigen::Lower>();
  // In raster order: fewer iterations than with a fill-reducing order, which an incomplete factor has no use
  // for.
  using Preconditioner =
      Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::NaturalOrdering<std::int64_t>>;
  Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower | Eigen::Upper, Preconditioner> gradients;
  gradients.setTolerance(tolerance);
  gradients.setMaxIterations(most_iterations);
  gradients.compute(matrix);
  if (gradients.info() != Eigen::Success) {
    throw InputError(
        "the finite element system has no incomplete Cholesky factor: the moduli differ too much");
  }
  const Eigen::VectorXd solution = gradients.solve(system.right_side);
  const double largest = system.right_side.norm();
  const double residual = largest > 0.0 ? (matrix * solution - system.right_side).norm() / largest : 0.0;
  if (gradients.info() != Eigen::Success || !solution.allFinite()) {
    throw InputError(fmt::format("conjugate gradients left a residual of {:.2g} after {} iterations, above "
                                 "the tolerance {}",
                                 residual, gradients.iterations(), tolerance));
  }
  return {displacement_of(problem, system, solution), static_cast<int>(gradients.iterations()), residual};
}

} // namespace hdmbench
