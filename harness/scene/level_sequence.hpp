#pragma once

#include "harness/scene/scene.hpp"

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace hdmbench {

/// The levels of a scene's pyramid in the order they are computed (thesis Alg. 3). Every level samples level
/// 0, never a resampled copy. The scene must outlive this object.
class LevelSequence {
public:
  explicit LevelSequence(const Scene& scene);

  /// Indices of the levels, coarsest first; 0 is the full resolution and comes last. A start level beyond the
  /// coarsest counts as the coarsest.
  [[nodiscard]] const std::vector<int>& order() const { return order_; }
  [[nodiscard]] Extent extent(int level) const { return extents_[static_cast<std::size_t>(level)]; }
  /// How many the schedule gives a level, exact or at most (Stop).
  [[nodiscard]] int iterations(int level) const;
  /// Level::strengths of its sweeps.
  [[nodiscard]] std::vector<float> strengths(int level) const;

  /// The whole sequence in one piece, where nothing on the way asks for the host: a fixed number of
  /// iterations, a null start, nearest moduli, no curvatures. Valid as long as the scene.
  [[nodiscard]] std::optional<Pyramid> pyramid() const;

  /// A level with all that its sweeps need; valid until the next call.
  [[nodiscard]] const Level& sample(int level);
  /// The same with relaxation 1 in every sweep, which cannot diverge; valid until the next call.
  [[nodiscard]] const Level& sample_without_acceleration(int level);
  /// The displacement a level begins with: the scene's start, and on it what the level computed before has
  /// changed of it, interpolated. So a start keeps its details on every level; a null start leaves what was
  /// computed before, interpolated (thesis Alg. 3).
  [[nodiscard]] VectorField begin(int level, const VectorField& computed_before) const;

private:
  const Scene& scene_;
  std::vector<Extent> extents_;
  std::vector<int> order_;
  Level sampled_;
  bool has_start_ = false; ///< whether it is not the null field
};

/// Whether sweeps with factors above 1 carried a level's field out of the range of the conditions and of what
/// it began with, by more than 2 % of the range: the system is not symmetric, and strong contrasts give it
/// complex eigenvalues, with which over-relaxation diverges. The level is then to be computed without
/// acceleration. False for all other rules and factors.
[[nodiscard]] bool has_diverged(const Level& level, const VectorField& begin, const VectorField& end);

/// Decides after each iteration whether a level is finished.
class StopRule {
public:
  /// At most `limit` iterations.
  StopRule(const Schedule& schedule, int limit) : schedule_(schedule), limit_(limit) {}

  /// Asked before each iteration.
  [[nodiscard]] bool may_continue(int iterations_done) const { return !stopped_ && iterations_done < limit_; }
  /// Whether report() needs the field at all.
  [[nodiscard]] bool needs_field() const { return schedule_.stop == Stop::energy; }
  /// After an iteration: the number of sites its sweeps changed and, where needs_field(), the new
  /// displacement.
  void report(std::int64_t changed, const Level& level, const VectorField& displacement);

private:
  const Schedule& schedule_;
  int limit_;
  bool stopped_ = false;
  double energy_ = std::numeric_limits<double>::infinity(); ///< mean, after the iteration before
};

} // namespace hdmbench
