#pragma once

#include "backends/backend.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

/// Seconds of wall clock spent in the parts of a solution.
struct Timings {
  /// On the host: sampling the levels, interpolating the displacement between them. 0 where the session does
  /// that itself, as part of compute or, for what does not change, of upload.
  double projection = 0.0;
  double upload = 0.0;   ///< load and write
  double compute = 0.0;  ///< step and changed, or solve
  double readback = 0.0; ///< read

  [[nodiscard]] double total() const { return projection + upload + compute + readback; }
  void add(const Timings& other) {
    projection += other.projection;
    upload += other.upload;
    compute += other.compute;
    readback += other.readback;
  }
};

struct LevelResult {
  int level = 0;
  Extent extent;
  int iterations = 0;
  int residuals = 0; ///< evaluations of the residual of all sites on the host, each the work of an iteration
  std::int64_t changed = 0; ///< sites that the last sweep changed
  /// Acceleration diverged (level_sequence.hpp), so the level was computed again without; its iterations
  /// count both.
  bool repeated = false;
};

struct Solution {
  VectorField displacement; ///< full resolution, pixels
  std::vector<LevelResult> levels;
  Timings timings;
  /// The estimate of the RMSD of `displacement` and the fixed point, pixels; none where the method has none.
  std::optional<double> estimated_error{};
  bool grew = false; ///< cycles moved the field farther and farther, and were ended
  /// Says why laws of large strains have no answer; empty: they have one, or there are none.
  std::string failure{};
  /// Says where a cell has been pressed together farther than such laws hold; empty: nowhere.
  std::string beyond_law{};
  /// Says where the body would buckle out of the balance that `displacement` is; empty: nowhere that was
  /// seen.
  std::string buckling{};
  /// Is the place around which forces pushed the body on while it was solved, as where it buckles; empty:
  /// there was none.
  std::string gave_way_at{};
  /// Is there with such laws: the least share of its volume, or of its area, that a cell has kept at a Gauss
  /// point. Cells that are prescribed altogether do not count.
  std::optional<double> least_volume{};
  std::optional<Extent>
      part{}; ///< of the scene, where not all of it was solved, but what conditions let move
};

/// Returns why the field is not what tissue with laws of large strains would do, though it is what was solved
/// for: beyond_law, or buckling; empty: it is.
[[nodiscard]] inline const std::string& doubt_about(const Solution& solution) {
  return solution.beyond_law.empty() ? solution.buckling : solution.beyond_law;
}

/// The method's name in results; that of the update where it alone differs from icm: "sequential".
[[nodiscard]] std::string method_name(const Scene& scene);

struct SolveOptions {
  /// The scene that is solved, where nobody else reads it meanwhile: with the elastic energy its fields may
  /// then be set aside (set_aside.hpp), and are back in the end. Null: it is left as it is.
  Scene* unread = nullptr;
  bool last_changed = false; ///< LevelResult::changed also where the stop rule does not need it
  /// Called after each level with its field; not part of the timings.
  std::function<void(const LevelResult&, const VectorField&)> level_done{};
};

/// The scene's schedule on an open session: in one piece where LevelSequence::pyramid() has one and `options`
/// want nothing on the way, else level by level. With Stop::fixed each level is one call of step, so that a
/// device is never interrupted. Throws what Session throws.
[[nodiscard]] Solution solve(const Scene& scene, Session& session, Progress& progress,
                             const SolveOptions& options = {});

/// The largest |component|, pixels; infinite where one is not a number, 0 of an empty field. Sites where
/// `tissue` is 0 do not count; empty: all do.
[[nodiscard]] double largest_component(const VectorField& field, const ScalarField& tissue = {});

/// Returns the sum of the products of all components, in double, row by row: the same bits whatever the
/// number of threads.
[[nodiscard]] double dot(const VectorField& first, const VectorField& second);
/// Returns the root of the mean square over sites, pixels.
[[nodiscard]] double root_mean_square(const VectorField& field);

/// Says why no energy can have the field of this solution; empty: it can. The limit is far beyond any lever
/// that the image has room for.
[[nodiscard]] std::string why_absurd(const Scene& scene, const Solution& solution);

/// Iterations over all levels.
[[nodiscard]] std::int64_t total_iterations(std::span<const LevelResult> levels);

/// Iterations times sites over all levels, residuals among them, as they were done.
[[nodiscard]] double total_site_updates(std::span<const LevelResult> levels);

/// Iterations times sites over all levels, the unit of work of a solution; `iteration_limit` caps the
/// schedule's iterations per level. With Stop::fixed this is what
/// progress goes by, exact but for levels that are repeated, else the most that can be needed. Of cycles and
/// Krylov steps, those on the full resolution count, once.
[[nodiscard]] double site_updates(const Scene& scene, std::optional<int> iteration_limit = std::nullopt);

} // namespace hdmbench
