#pragma once

#include "harness/check/verify.hpp"
#include "harness/check/windows.hpp"

namespace hdmbench {

/// How the last and largest level is computed, on which memory may be short.
enum class LastLevel {
  both,             ///< level by level and in one piece: a hash of all sites is compared, too
  levels_only,      ///< a session that loads a level has a copy of it
  in_one_piece_only ///< the levels before it level by level; a session may use the scene in place
};

struct WindowOptions {
  SessionOptions session{};
  WindowPlan plan{};
  std::size_t whole = 1024 * 1024;      ///< levels of up to so many sites are compared whole
  std::optional<int> iteration_limit{}; ///< per level
  /// How the full resolution is computed. In one piece where the schedule allows it, else level by level.
  LastLevel last_level = LastLevel::both;
};

/// A site at which backend and scalar differ.
struct DifferingSite {
  int x = 0;
  int y = 0;
  std::array<float, 2> expected{}; ///< displacement (x, y), pixels
  std::array<float, 2> found{};
};

/// What was seen of one level, after all its sweeps.
struct WindowedLevel {
  int level = 0;
  Extent extent;
  int iterations = 0;
  int sweeps = 0;
  bool level_by_level = true;      ///< else the field is that of the first pyramid in one piece
  bool whole = false;              ///< every site, and the count of changed sites
  std::vector<Window> windows{};   ///< compared; of a whole level the only one
  std::int64_t sites_compared = 0; ///< once each
  std::int64_t sites_differing = 0;
  std::int64_t not_finite = 0;     ///< of these
  double largest_difference = 0.0; ///< pixels, over the finite sites
  bool count_differs = false;
  std::optional<DifferingSite> first{}; ///< in the order of windows, in each in reading order
};

/// The whole pyramid by one call.
struct WindowedPyramid {
  Work work = Work::dense;
  std::int64_t sites_differing = 0; ///< in the windows of the last level, from scalar
  std::optional<bool> same_field{}; ///< as level by level, by state_hash(); none where that was not computed
  std::optional<bool> same_count{}; ///< as level by level
};

/// One backend on an image that is too large for scalar.
struct WindowedComparison {
  std::string backend{};
  Device device{};
  std::vector<WindowedLevel> levels{}; ///< coarsest first
  std::vector<WindowedPyramid> pyramids{};
  Verdict verdict = Verdict::skipped; ///< agree, disagree or skipped
  std::string reason;                 ///< of skipped
};

/// Runs the scene's schedule on `backend` level by level; after the sweeps of each level, scalar makes the
/// same sweeps from the field that the backend's level began with, on the whole level or on windows of it
/// with all that can have an influence on them, and the bits are compared. So is what the backend makes of
/// the whole pyramid in one piece, as options.last_level says. What no window shows is not known. Of the
/// scene and the fields nothing is kept longer than it is needed, `scene` included, because they are large. A
/// backend whose devices() or open() throws DeviceError, or for which a level is TooLarge, is skipped with
/// that reason; another error later is not caught. Throws InputError for schedules with another stop than a
/// fixed number of iterations, sequential updates, annealing, or cycles.
[[nodiscard]] WindowedComparison verify_windows(Scene scene, const Backend& reference, const Backend& backend,
                                                const WindowOptions& options, Progress& progress);

/// What progress is told of it: site updates of the backend.
[[nodiscard]] double windowed_site_updates(const Scene& scene, const WindowOptions& options);

} // namespace hdmbench
