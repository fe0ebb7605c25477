#pragma once

#include "reference/elastic_krylov.hpp"

namespace hdmbench {

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
