#pragma once

#include "backends/backend.hpp"
#include "harness/solve/methods/coarsest_solver.hpp"
#include "harness/solve/methods/level_parts.hpp"
#include "harness/solve/methods/residual.hpp"
#include "harness/solve/methods/restriction.hpp"
#include "harness/solve/solve.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace hdmbench {

/// The W-cycle of multigrid: an approximation of the correction e that a field misses to the fixed point. The
/// device smooths in float (Rule::correction, two colours); the host evaluates residuals in double, hands
/// them down and solves the coarsest level exactly.
///
/// The levels are those of the pyramid by their longer side; the shorter one keeps the ratio of the sides,
/// else what is steep along one axis would be flat along the other on the coarse level and its answer wrong.
/// Position 0 is the full resolution. Fields of a level have what `parts` loads of it.
class CorrectionCycle {
public:
  /// `sessions`, by position, is filled up as they are needed; it, `scene`, `backend` and `parts` must
  /// outlive this object. scene.full has what is loaded.
  CorrectionCycle(const Scene& scene, const Backend& backend, const SessionOptions& options,
                  std::vector<std::unique_ptr<Session>>& sessions, const LevelParts& parts);

  /// Position of the coarsest level, at most 100 sites.
  [[nodiscard]] int coarsest() const { return static_cast<int>(levels_.size()) - 1; }
  [[nodiscard]] Extent extent(int position) const { return at(position).extent; }
  /// Index of the level in pyramid_extents().
  [[nodiscard]] int index(int position) const { return at(position).index; }

  /// Which components of the level stay as they are (1 where held); the coarser levels follow.
  void hold(int position, const VectorField& held);
  [[nodiscard]] const VectorField& held(int position) const { return at(position).level.confidence; }
  /// g / A of the level with the sign turned: its residual without observations.
  [[nodiscard]] const Residual& gradient(int position) const { return *at(position).gradient; }
  /// One cycle with `position` as the finest level. `missing` is what each component misses to its own
  /// minimiser, pixels, not read where held; the correction is 0 there. It may be wrong at the rim of a halo,
  /// the correction is right in all of it. Throws what Session and LevelParts throw.
  [[nodiscard]] VectorField correct(int position, const DoubleField& missing);

  /// What was done so far, by position.
  [[nodiscard]] std::vector<LevelResult> work() const;
  [[nodiscard]] const Timings& timings() const { return timings_; }

private:
  struct CycleLevel {
    int index = 0;
    Extent extent{};       ///< of the whole level
    bool is_built = false; ///< whether what follows is there: a fine level may never be needed
    Level level{};         ///< target: what is missing; confidence: 1 where held
    std::optional<Residual> gradient{};
    std::optional<Restriction> to_coarser{};
    ResidualField residual{};
    int sweeps = 0;
    int residuals = 0;
  };

  [[nodiscard]] CycleLevel& at(int position) { return *levels_[static_cast<std::size_t>(position)]; }
  [[nodiscard]] const CycleLevel& at(int position) const {
    return *levels_[static_cast<std::size_t>(position)];
  }
  /// Samples the level, and what hands its residual to the next coarser one, unless that was done.
  CycleLevel& built(int position);
  [[nodiscard]] Session& session(int position);
  /// Improves e, from 0, on a level whose target is set.
  [[nodiscard]] VectorField improved(int position, int visits);
  void restrict_missing(int position, const VectorField& correction);

  const Scene& scene_;
  const Backend& backend_;
  SessionOptions options_;
  std::vector<std::unique_ptr<Session>>& sessions_;
  const LevelParts& parts_;
  Alignment alignment_;
  std::vector<std::unique_ptr<CycleLevel>> levels_; ///< pointers: Residual keeps the address of its level
  CoarsestSolver coarsest_;
  Timings timings_;
};

} // namespace hdmbench
