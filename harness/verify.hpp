#pragma once

#include "backends/backend.hpp"
#include "harness/progress.hpp"
#include "harness/scene.hpp"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

/// How a backend is led along the reference.
enum class Mode {
  resync, ///< every iteration starts from the reference's field: what one iteration gets wrong
  free,   ///< each runs on its own from the start: what becomes of it
};

enum class Verdict { // the worst last
  agree,             ///< all bits equal, at every iteration
  skipped,           ///< the backend is not there
  mistrusted,        ///< nothing differed, but the scene could not have shown a difference
  disagree,          ///< a site or a count of changes differs
};

/// Where a backend left the reference first.
struct FirstDifference {
  int level = 0;
  int iteration = 0; ///< 1 is the first
  int x = 0;
  int y = 0;
  std::array<float, 2> expected{}; ///< displacement (x, y), pixels
  std::array<float, 2> found{};
  // U_t of that site in double: before the iteration, and with either answer as the centre's displacement.
  double energy_before = 0.0;
  double energy_expected = 0.0;
  double energy_found = 0.0;
};

/// One backend against the reference on one scene in one mode.
struct Comparison {
  std::string backend;
  Device device;
  Mode mode = Mode::resync;
  int levels = 0;
  std::int64_t iterations = 0;
  std::int64_t sweeps = 0;           ///< compared; one, two or four an iteration (level.hpp)
  std::int64_t sites_compared = 0;   ///< over all sweeps
  std::int64_t sites_differing = 0;  ///< over all sweeps
  std::int64_t not_finite = 0;       ///< of these, NaN or infinite
  std::int64_t counts_differing = 0; ///< sweeps after which changed() was not the reference's
  double largest_difference = 0.0;   ///< pixels
  std::optional<FirstDifference> first;
  Verdict verdict = Verdict::skipped;
  std::string reason; ///< for mistrusted and skipped
};

struct VerifyOptions {
  SessionOptions session;
  std::optional<int> iteration_limit; ///< per level, for a shorter run
};

/// Runs the scene's schedule on `reference` and on all `backends` side by side and compares the whole field
/// and the count of changed sites after every sweep of every level. A backend whose devices() or open()
/// throws DeviceError is skipped with that reason; an error later is not caught. Returns two comparisons
/// (resync, free) per backend, in their order.
[[nodiscard]] std::vector<Comparison> verify(const Scene& scene, const Backend& reference,
                                             std::span<const Backend* const> backends,
                                             const VerifyOptions& options, Progress& progress);

} // namespace hdmbench
