#pragma once

#include "harness/methods/correction_cycle.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace hdmbench {

/// How a cycle went.
struct CycleResult {
  double correction = 0.0; ///< RMS over the sites of the way the field moved, pixels
  double residual = 0.0; ///< RMS of what each component misses to its own minimiser, after the cycle, pixels
  double contraction = 1.0; ///< residual / residual before the cycle, 0 where that was 0
};

/// Multigrid for the fixed point, one step at a time: a field in double on one level, which cycles bring
/// closer to that level's fixed point. Conditions are an absolute value (K c |y - d|): which of them hold
/// their component is decided anew from the residual before each cycle.
class Multigrid {
public:
  /// Positions of levels, `sessions` and lifetimes are those of CorrectionCycle. Throws InputError where no
  /// field is the only fixed point: a component that nothing holds anywhere.
  Multigrid(const Scene& scene, const Backend& backend, const SessionOptions& options,
            std::vector<std::unique_ptr<Session>>& sessions);

  [[nodiscard]] int coarsest() const { return cycle_.coarsest(); }
  [[nodiscard]] Extent extent(int position) const { return cycle_.extent(position); }

  /// Takes `field`, of the extent of the level, and imposes the conditions.
  void start(int position, const VectorField& field);
  /// Goes on with the next finer level: the field interpolated, the conditions imposed.
  void refine();
  /// One W-cycle with the current level as the finest.
  CycleResult cycle();

  [[nodiscard]] int position() const { return position_; }
  [[nodiscard]] const DoubleField& field() const { return field_; }
  /// Of field().
  [[nodiscard]] const ResidualField& residual() const { return residual_; }
  /// RMSD of field() and the fixed point of the current level, pixels: from the last cycle's correction and
  /// the contraction measured; none before the first cycle of a level.
  [[nodiscard]] std::optional<double> estimated_error() const { return estimated_error_; }

  /// What was done so far, coarsest level first.
  [[nodiscard]] std::vector<LevelResult> work() const;
  [[nodiscard]] Timings timings() const;

private:
  struct Problem {
    const Level* level = nullptr;
    std::unique_ptr<Level> sampled{}; ///< what `level` points to, but on the full resolution
    std::unique_ptr<Residual> residual{};
    int residuals = 0;
  };

  [[nodiscard]] Problem& problem() { return problems_[static_cast<std::size_t>(position_)]; }
  enum class Hold { all_observed, by_residual };
  void evaluate(Hold hold);

  CorrectionCycle cycle_;
  Alignment alignment_;
  std::vector<Problem> problems_; ///< by position
  int position_ = 0;
  DoubleField field_;
  ResidualField residual_;
  VectorField held_; ///< 1 where the next cycle keeps the component on its target
  std::optional<double> estimated_error_;
  std::optional<double> last_correction_; ///< of this level
  Timings timings_;
};

/// Full multigrid: the fixed point of the coarsest level, one cycle on each finer one, then
/// scene.schedule.iterations cycles on the full resolution. Throws what Multigrid and Session throw.
[[nodiscard]] Solution solve_multigrid(const Scene& scene, const Backend& backend,
                                       const SessionOptions& options,
                                       std::vector<std::unique_ptr<Session>>& sessions, Progress& progress,
                                       const SolveOptions& solve_options = {});

} // namespace hdmbench
