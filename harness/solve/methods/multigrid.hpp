#pragma once

#include "harness/solve/methods/correction_cycle.hpp"
#include "harness/solve/methods/krylov.hpp"

#include <array>
#include <functional>
#include <limits>
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

struct KrylovRound {
  int steps = 0; ///< 0 where nothing was missing
  CycleResult result;
};

/// From the least to the greatest target of a component, pixels. No fixed point leaves it: a free component
/// is a mean of its neighbours.
struct Range {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
};

/// Multigrid for the fixed point, one step at a time: a field in double on one level, which cycles bring
/// closer to that level's fixed point. Conditions are an absolute value (K c |y - d|): which of them hold
/// their component is decided anew from the residual before each cycle.
class Multigrid {
public:
  /// Positions of levels, `sessions`, `parts` and lifetimes are those of CorrectionCycle. Throws InputError
  /// where no field is the only fixed point: a component that nothing holds anywhere.
  Multigrid(const Scene& scene, const Backend& backend, const SessionOptions& options,
            std::vector<std::unique_ptr<Session>>& sessions, const LevelParts& parts = whole_image());

  /// Largest over smallest modulus up to which estimates are believed. Coarse levels sample the moduli;
  /// beyond it, what they do not know of was seen to stall without a sign (test/promise_test holds what is
  /// left).
  static constexpr double most_trusted_contrast = 10.0;
  [[nodiscard]] bool is_trusted() const { return is_trusted_; }

  [[nodiscard]] int coarsest() const { return cycle_.coarsest(); }
  [[nodiscard]] Extent extent(int position) const { return cycle_.extent(position); }

  using LevelDone = std::function<void(const LevelResult&, const VectorField&)>;
  /// Full multigrid: the fixed point of the coarsest level, then one cycle on each finer one; ends with the
  /// full resolution started. `start` is of what is loaded of the full resolution; `level_done` is told of
  /// each level but that.
  void start_from_coarsest(const VectorField& start, const LevelDone& level_done = {});
  /// Takes `field`, of the extent of the level, and imposes the conditions.
  void start(int position, const VectorField& field);
  /// Goes on with the next finer level: the field interpolated, the conditions imposed.
  void refine();
  /// One W-cycle with the current level as the finest. On the full resolution a cycle that leaves more than
  /// 0.9 of the residual is taken back and krylov_round() done in its place.
  CycleResult cycle();
  /// BiCGSTAB for the same correction with the W-cycle as its preconditioner, see krylov_correction(); the
  /// held set is that of the beginning. Where that does not help either it is taken back for plain sweeps of
  /// the closed form on the host: they always converge, but slowly, and leave no estimated_error(). Known to
  /// need them: so small a K, or targets so contradictory, that most conditions are not held.
  KrylovRound krylov_round(int most_steps, double tolerance);

  [[nodiscard]] int position() const { return position_; }
  /// What is loaded of the level that field() is on.
  [[nodiscard]] const Level& level() const { return *problems_[static_cast<std::size_t>(position_)].level; }
  [[nodiscard]] const DoubleField& field() const { return field_; }
  /// Of field().
  [[nodiscard]] const ResidualField& residual() const { return residual_; }
  /// RMSD of field() and the fixed point of the current level, pixels: from the last cycle's correction and
  /// the contraction measured; none before the first cycle of a level, after plain sweeps, and where it would
  /// not be trusted.
  [[nodiscard]] std::optional<double> estimated_error() const {
    return is_trusted_ ? estimated_error_ : std::nullopt;
  }

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
  /// What a step that does not help is taken back to.
  struct State {
    DoubleField field;
    ResidualField residual;
    VectorField held;
  };
  void restore(const State& state);
  CycleResult sweep(int iterations);
  /// RMS of the way from one field to the other, pixels.
  [[nodiscard]] double distance(const DoubleField& from, const DoubleField& to) const;
  enum class Hold { all_observed, by_residual };
  void evaluate(Hold hold);
  /// Moves the field, which is `from`, and says how that went.
  template <typename Field>
  CycleResult add(const DoubleField& from, const Field& correction);

  const LevelParts& parts_;
  CorrectionCycle cycle_;
  bool is_trusted_;
  Alignment alignment_;
  std::array<Range, 2> ranges_;   ///< of x and y
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
/// scene.schedule.iterations cycles on the full resolution. Throws what Multigrid, Session and LevelParts
/// throw.
[[nodiscard]] Solution solve_multigrid(const Scene& scene, const Backend& backend,
                                       const SessionOptions& options,
                                       std::vector<std::unique_ptr<Session>>& sessions, Progress& progress,
                                       const SolveOptions& solve_options = {});

/// The same with steps of krylov_round() in place of the cycles at the end.
[[nodiscard]] Solution solve_krylov(const Scene& scene, const Backend& backend, const SessionOptions& options,
                                    std::vector<std::unique_ptr<Session>>& sessions, Progress& progress,
                                    const SolveOptions& solve_options = {});

/// A solution with the RMS of what each component of the field, which is known in double, misses to its own
/// minimiser, pixels.
struct CycleSolution : Solution {
  double residual = 0.0;
};

/// What scene.schedule.cycle says of the two, where others have parts of the image: scene.full and the result
/// are what is loaded here.
[[nodiscard]] CycleSolution solve_on_parts(const Scene& scene, const Backend& backend,
                                           const SessionOptions& options, const LevelParts& parts,
                                           Progress& progress, const SolveOptions& solve_options = {});

} // namespace hdmbench
