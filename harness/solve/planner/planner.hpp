#pragma once

#include "backends/backend.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/planner/survey.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/solve.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// What the user wants; one of the two is set, or both.
struct Request {
  /// RMSD to the fixed point of the thesis's energy, or to finite elements where the energy is elastic;
  /// pixels, > 0.
  std::optional<double> accuracy{};
  std::optional<double> seconds{}; ///< wall clock of the whole solution, > 0
};

/// One thing that was done on the way.
struct PlanStep {
  Extent extent;               ///< of the level it was done on
  std::string action;          ///< "start", "cycle", "interpolation", "gradients"
  std::string reason;          ///< why, in words, with the figures that decided
  double moved = 0.0;          ///< RMS of the way the field moved, pixels
  double expected_error = 0.0; ///< as Request::accuracy, after it, as far as is known there; else infinite
  double seconds = 0.0;        ///< since the beginning
};

/// A field as accurate as requested, at no more cost than that takes, and how it was found.
struct Plan {
  Solution solution;              ///< with estimated_error, where there is one
  std::vector<Resolution> levels; ///< that it could choose from, the full resolution first
  std::vector<PlanStep> steps;
  bool met = false;    ///< the estimate is within the accuracy, the clock within the seconds
  std::string outcome; ///< one sentence for people
};

/// Says how the plan of the scene ended: from its estimate, after `seconds`; `truth` is what the estimate is
/// the distance from. Without an estimate, or with `mistrust` (why it cannot be believed), no accuracy is
/// met; with a field that cannot be one (why_absurd) nothing is.
void conclude(Plan& plan, const Scene& scene, const Request& request, double seconds, std::string_view truth,
              std::string_view mistrust = {});

/// Work of the plan in sweeps over the full resolution.
[[nodiscard]] double fine_sweep_equivalents(const Plan& plan);

/// Computes the fixed point of the scene on ever finer levels, each interpolated from the one before and
/// corrected by multigrid, and stops at the coarsest one whose interpolation is expected to be good enough
/// and to lose no condition; else the full resolution gets as many cycles as the request needs. The estimate
/// is of the last correction and of what cycles were seen to leave of one, or of the differences between the
/// levels. Beyond Multigrid::most_trusted_contrast cycles can stall unseen: an image of at most 250,000 sites
/// is then solved by a factorisation, a larger one's estimate is not believed. `sessions` are kept for the
/// next plan. Throws InputError where a figure of the request is not positive or no field is the only fixed
/// point; what Session throws. With the elastic energy: elastic_planner.hpp.
[[nodiscard]] Plan solve_as_needed(const Scene& scene, const Request& request, const Backend& backend,
                                   const SessionOptions& options,
                                   std::vector<std::unique_ptr<Session>>& sessions, Progress& progress);

} // namespace hdmbench
