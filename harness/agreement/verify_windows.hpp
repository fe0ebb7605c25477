#pragma once

#include "harness/agreement/verify.hpp"
#include "harness/agreement/windows.hpp"

namespace hdmbench {

struct WindowOptions {
  SessionOptions session{};
  WindowPlan plan{};
  std::size_t whole = 1024 * 1024;      ///< levels of up to so many sites are compared whole
  std::optional<int> iteration_limit{}; ///< per level
  bool in_one_piece = true; ///< also solve the whole pyramid by one call, if the schedule allows it
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
  bool whole = false;              ///< every site, and the count of changed sites
  std::vector<Window> windows{};   ///< compared; of a whole level the only one
  std::int64_t sites_compared = 0; ///< once each
  std::int64_t sites_differing = 0;
  std::int64_t not_finite = 0;     ///< of these
  double largest_difference = 0.0; ///< pixels, over the finite sites
  bool count_differs = false;
  std::optional<DifferingSite> first{}; ///< in the order of windows, in each in reading order
};

/// The whole pyramid by one call, against the levels one by one.
struct WindowedPyramid {
  Work work = Work::dense;
  bool same_field = false; ///< by state_hash()
  bool same_count = false;
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
/// with all that can have an influence on them, and the bits are compared. What no window shows is not known.
/// Of the scene and the fields nothing is kept longer than it is needed, `scene` included, because they are
/// large. A backend whose devices() or open() throws DeviceError is skipped with that reason; an error later
/// is not caught. Throws InputError for schedules with another stop than a fixed number of iterations,
/// sequential updates, annealing, or cycles.
[[nodiscard]] WindowedComparison verify_windows(Scene scene, const Backend& reference, const Backend& backend,
                                                const WindowOptions& options, Progress& progress);

/// What progress is told of it: site updates of the backend.
[[nodiscard]] double windowed_site_updates(const Scene& scene, const WindowOptions& options);

} // namespace hdmbench
