#pragma once

#include "reference/finite_elements.hpp"

namespace hdmbench {

struct IterativeSolution {
  ReferenceField displacement; ///< pixels
  int iterations = 0;
  double residual = 0.0; ///< |b - K u| / |b| over the unknowns
};

/// The same finite elements by conjugate gradients preconditioned with an incomplete Cholesky factor, from 0
/// until the residual is at most `tolerance` times the right side: what a careful user would set against the
/// direct factorisation where the last digits are not wanted. 0 < tolerance < 1. Throws InputError as
/// solve_finite_elements does, for a tolerance out of range, and where `most_iterations` do not reach it.
[[nodiscard]] IterativeSolution solve_finite_elements_iteratively(const ElasticProblem& problem,
                                                                  const ElementRule& rule, double tolerance,
                                                                  int most_iterations = 20000);

/// Throws InputError where it is not above 0 and below 1.
void require_tolerance(double tolerance);

/// Whether this build has PETSc (-DHDMBENCH_PETSC=ON).
[[nodiscard]] bool has_algebraic_multigrid();

/// The same finite elements by conjugate gradients with smoothed aggregation (PETSc's GAMG, one process) that
/// knows the rigid motions of the sheet: what a user of a multigrid library would set up. Its own figures
/// are left as they come, but for the smoother: Chebyshev with Jacobi. From 0 until the preconditioned
/// residual is at most `tolerance` times the first one. Throws InputError as
/// solve_finite_elements_iteratively does, and where the build has none.
[[nodiscard]] IterativeSolution solve_finite_elements_by_multigrid(const ElasticProblem& problem,
                                                                   const ElementRule& rule, double tolerance);

} // namespace hdmbench
