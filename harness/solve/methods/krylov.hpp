#pragma once

#include "harness/solve/methods/residual.hpp"

#include <functional>

namespace hdmbench {

/// The linear system of a correction e: g(e) / A = missing where a component is free, e = 0 where it is held.
struct CorrectionSystem {
  const Residual& gradient;   ///< without observations
  const VectorField& held;    ///< 1 where held, else 0
  const DoubleField& missing; ///< pixels, not read where held
};

/// An approximate solution of the system for another `missing`: one multigrid cycle.
using Preconditioner = std::function<VectorField(const DoubleField& missing)>;

struct KrylovResult {
  DoubleField correction;
  int steps = 0;    ///< done; two applications of preconditioner and matrix each
  int products = 0; ///< of matrix and vector, each the work of a residual
};

/// BiCGSTAB in double from e = 0 (the system is not symmetric), at most `most_steps` steps, fewer once what
/// is left of `missing` is below `tolerance` of it in RMS.
[[nodiscard]] KrylovResult krylov_correction(const CorrectionSystem& system,
                                             const Preconditioner& preconditioner, int most_steps,
                                             double tolerance);

} // namespace hdmbench
