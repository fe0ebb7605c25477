#pragma once

#include "harness/solve/methods/level_parts.hpp"
#include "harness/solve/methods/residual.hpp"

#include <functional>

namespace hdmbench {

/// The linear system of a correction e: g(e) / A = missing where a component is free, e = 0 where it is held.
/// Fields have what `parts` loads of the level.
struct CorrectionSystem {
  const Residual& gradient;   ///< without observations
  const VectorField& held;    ///< 1 where held, else 0
  const DoubleField& missing; ///< pixels, not read where held; may be wrong at the rim of a halo
  Extent level;
  const LevelParts& parts;
};

/// An approximate solution of the system for another `missing`, right in all of a halo: one multigrid cycle.
using Preconditioner = std::function<VectorField(const DoubleField& missing)>;

struct KrylovResult {
  DoubleField correction; ///< right in all of a halo
  int steps = 0;          ///< done; two applications of preconditioner and matrix each
  int products = 0;       ///< of matrix and vector, each the work of a residual
};

/// BiCGSTAB (van der Vorst 1992) in double from e = 0 (the system is not symmetric), at most `most_steps`
/// steps, fewer once what is left of `missing` is below `tolerance` of it in RMS. Sums go row by row: the
/// same bits for any number of threads and processes.
[[nodiscard]] KrylovResult krylov_correction(const CorrectionSystem& system,
                                             const Preconditioner& preconditioner, int most_steps,
                                             double tolerance);

} // namespace hdmbench
