#include "reference/finite_elements.hpp"

#include "kernels/data/input_error.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <fmt/format.h>
#ifdef HDMBENCH_PETSC
#include <petscksp.h>
#endif

#include <algorithm>
#include <memory>
#include <utility>

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

#ifdef HDMBENCH_PETSC

namespace {

void require(PetscErrorCode code, const char* call) {
  if (code != 0) {
    const char* words = nullptr;
    (void)PetscErrorMessage(code, &words, nullptr);
    throw InputError(fmt::format("PETSc: {} failed: {}", call, words == nullptr ? "no message" : words));
  }
}

/// PETSc and MPI, once a process: they cannot begin a second time.
struct Petsc {
  Petsc() { require(PetscInitializeNoArguments(), "PetscInitialize"); }
  Petsc(const Petsc&) = delete;
  Petsc& operator=(const Petsc&) = delete;
  ~Petsc() { (void)PetscFinalize(); }
};

/// One of PETSc's objects, given back by its own function.
template <typename Handle, PetscErrorCode (*destroy)(Handle*)>
class Owned {
public:
  Owned() = default;
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  ~Owned() { (void)destroy(&handle_); }

  [[nodiscard]] Handle get() const { return handle_; }
  [[nodiscard]] Handle* out() { return &handle_; }

private:
  Handle handle_ = nullptr;
};
using Matrix = Owned<Mat, MatDestroy>;
using Vector = Owned<Vec, VecDestroy>;
using NullSpace = Owned<MatNullSpace, MatNullSpaceDestroy>;
using Solver = Owned<KSP, KSPDestroy>;

/// All components of all nodes, those that are prescribed as equations x = 0, so that the blocks of the
/// nodes stay whole: GAMG joins nodes, not components.
Eigen::SparseMatrix<double, Eigen::RowMajor, PetscInt> with_prescribed(const ElasticSystem& system) {
  const auto count = static_cast<PetscInt>(system.unknown.size());
  std::vector<PetscInt> component(static_cast<std::size_t>(system.lower.rows())); // of every unknown
  std::vector<Eigen::Triplet<double, PetscInt>> entries;
  const double usual = system.lower.diagonal().mean();
  for (PetscInt i = 0; i < count; ++i) {
    if (const std::int32_t column = system.unknown[static_cast<std::size_t>(i)]; column >= 0) {
      component[static_cast<std::size_t>(column)] = i;
    } else {
      entries.emplace_back(i, i, usual);
    }
  }
  for (Eigen::Index column = 0; column < system.lower.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator entry(system.lower, column); entry; ++entry) {
      const PetscInt of = component[static_cast<std::size_t>(entry.row())];
      const PetscInt by = component[static_cast<std::size_t>(column)];
      entries.emplace_back(of, by, entry.value());
      if (of != by) {
        entries.emplace_back(by, of, entry.value());
      }
    }
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor, PetscInt> whole(count, count);
  whole.setFromTriplets(entries.begin(), entries.end());
  return whole;
}

void set_coordinates(Extent extent, const Point& sides, Vec coordinates) {
  double* values = nullptr;
  require(VecGetArray(coordinates, &values), "VecGetArray");
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    const Point at = place(extent, site, sides);
    values = std::copy_n(at.begin(), extent.axes(), values);
  }
  values -= extent.axes() * extent.sites();
  require(VecRestoreArray(coordinates, &values), "VecRestoreArray");
}

} // namespace

bool has_algebraic_multigrid() {
  return true;
}

IterativeSolution solve_finite_elements_by_multigrid(const ElasticProblem& problem, const ElementRule& rule,
                                                     double tolerance) {
  require_tolerance(tolerance);
  static const Petsc petsc;
  const ElasticSystem system = assemble(problem, rule);
  auto rows = with_prescribed(system);
  const auto count = static_cast<PetscInt>(system.unknown.size());
  const auto axes = static_cast<PetscInt>(problem.extent.axes());

  Matrix matrix;
  require(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, count, count, rows.outerIndexPtr(), rows.innerIndexPtr(),
                                    rows.valuePtr(), matrix.out()),
          "MatCreateSeqAIJWithArrays");
  require(MatSetBlockSize(matrix.get(), axes), "MatSetBlockSize");
  require(MatSetOption(matrix.get(), MAT_SPD, PETSC_TRUE), "MatSetOption");
  Vector right_side;
  Vector solution;
  Vector coordinates;
  require(MatCreateVecs(matrix.get(), solution.out(), right_side.out()), "MatCreateVecs");
  require(VecDuplicate(solution.get(), coordinates.out()), "VecDuplicate");
  require(VecSetBlockSize(coordinates.get(), axes), "VecSetBlockSize");
  set_coordinates(problem.extent, problem.sides, coordinates.get());
  NullSpace rigid;
  require(MatNullSpaceCreateRigidBody(coordinates.get(), rigid.out()), "MatNullSpaceCreateRigidBody");
  require(MatSetNearNullSpace(matrix.get(), rigid.get()), "MatSetNearNullSpace");
  for (PetscInt i = 0; i < count; ++i) {
    if (const std::int32_t row = system.unknown[static_cast<std::size_t>(i)]; row >= 0) {
      require(VecSetValue(right_side.get(), i, system.right_side[row], INSERT_VALUES), "VecSetValue");
    }
  }
  require(VecAssemblyBegin(right_side.get()), "VecAssemblyBegin");
  require(VecAssemblyEnd(right_side.get()), "VecAssemblyEnd");

  Solver solver;
  require(KSPCreate(PETSC_COMM_SELF, solver.out()), "KSPCreate");
  require(KSPSetOperators(solver.get(), matrix.get(), matrix.get()), "KSPSetOperators");
  require(KSPSetType(solver.get(), KSPCG), "KSPSetType");
  PC preconditioner = nullptr; // the solver's
  require(KSPGetPC(solver.get(), &preconditioner), "KSPGetPC");
  require(PCSetType(preconditioner, PCGAMG), "PCSetType");
  for (const auto& [option, value] :
       {std::pair{"-mg_levels_ksp_type", "chebyshev"}, std::pair{"-mg_levels_pc_type", "jacobi"}}) {
    require(PetscOptionsSetValue(nullptr, option, value), "PetscOptionsSetValue");
  }
  require(KSPSetFromOptions(solver.get()), "KSPSetFromOptions");
  constexpr PetscInt most_iterations = 2000;
  require(KSPSetTolerances(solver.get(), tolerance, PETSC_DEFAULT, PETSC_DEFAULT, most_iterations),
          "KSPSetTolerances");
  require(KSPSolve(solver.get(), right_side.get(), solution.get()), "KSPSolve");
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  require(KSPGetConvergedReason(solver.get(), &reason), "KSPGetConvergedReason");
  require(KSPGetIterationNumber(solver.get(), &iterations), "KSPGetIterationNumber");
  if (reason < 0) {
    throw InputError(fmt::format("PETSc's multigrid did not converge in {} iterations (reason {})",
                                 iterations, static_cast<int>(reason)));
  }
  const double* values = nullptr;
  Eigen::VectorXd unknowns(system.right_side.size());
  require(VecGetArrayRead(solution.get(), &values), "VecGetArrayRead");
  for (std::size_t i = 0; i < system.unknown.size(); ++i) {
    if (system.unknown[i] >= 0) {
      unknowns[system.unknown[i]] = values[i];
    }
  }
  require(VecRestoreArrayRead(solution.get(), &values), "VecRestoreArrayRead");
  const Eigen::VectorXd left = system.lower.selfadjointView<Eigen::Lower>() * unknowns - system.right_side;
  return {displacement_of(problem, system, unknowns), static_cast<int>(iterations),
          left.norm() / system.right_side.norm()};
}

#else

bool has_algebraic_multigrid() {
  return false;
}

IterativeSolution solve_finite_elements_by_multigrid(const ElasticProblem&, const ElementRule&, double) {
  throw InputError("this build has no multigrid by others; configure with -DHDMBENCH_PETSC=ON (Debian: "
                   "petsc-dev)");
}

#endif

} // namespace hdmbench
