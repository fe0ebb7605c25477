#pragma once

#include "harness/solve/methods/residual.hpp"

#include <memory>

namespace hdmbench {

/// Solves the corrections of a small level exactly, by a dense factorisation that is kept as long as the held
/// set stays the same.
class CoarsestSolver {
public:
  /// Few enough for a dense factorisation.
  static constexpr std::size_t most_sites = 100;

  CoarsestSolver();
  CoarsestSolver(const CoarsestSolver&) = delete;
  CoarsestSolver& operator=(const CoarsestSolver&) = delete;
  CoarsestSolver(CoarsestSolver&&) noexcept;
  CoarsestSolver& operator=(CoarsestSolver&&) noexcept;
  ~CoarsestSolver();

  /// e with g(e) / A = level.target where level.confidence is 0, and e = 0 elsewhere. A component that is
  /// held nowhere is left at 0: any shift would solve it. `gradient` is the level's residual without
  /// observations.
  [[nodiscard]] VectorField solve(const Level& level, const Residual& gradient);

private:
  struct Factorised;
  std::unique_ptr<Factorised> factorised_;
};

} // namespace hdmbench
