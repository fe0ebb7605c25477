#pragma once

#include "backends/backend.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/solve.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

class Solver;

/// What the user wants; one of the two is set, or both.
struct Request {
  /// RMSD to finite elements with the scene's Poisson ratio, pixels, > 0.
  std::optional<double> accuracy{};
  std::optional<double> seconds{}; ///< wall clock of the whole solution, > 0
};

/// One thing that was done on the way.
struct PlanStep {
  Extent extent;               ///< of the image it was done on
  std::string action;          ///< "sampled image", "interpolation", "gradients"
  std::string reason;          ///< why, in words, with the figures that decided
  double moved = 0.0;          ///< RMS of the way the field moved, pixels
  double expected_error = 0.0; ///< as Request::accuracy, after it, as far as is known there; else infinite
  double seconds = 0.0;        ///< since the beginning
};

/// A field as accurate as requested, at no more cost than that takes, and how it was found.
struct Plan {
  Solution solution; ///< with estimated_error, where there is one
  std::vector<PlanStep> steps;
  /// Where tissues have laws of large strains and the linear solution is near enough to what they have: how
  /// far it is from that, pixels.
  std::optional<double> linear_distance{};
  bool met = false;    ///< the estimate is within the accuracy, the clock within the seconds
  std::string outcome; ///< one sentence for people
};

/// Says how the plan of the scene ended: from its estimate, after `seconds`. Without an estimate, or with
/// `mistrust` (why it cannot be believed), nothing is met, and nor is it with a field that cannot be one
/// (why_absurd).
void conclude(Plan& plan, const Scene& scene, const Request& request, double seconds,
              std::string_view mistrust = {});

/// Work of the plan in sweeps over the full resolution.
[[nodiscard]] double fine_sweep_equivalents(const Plan& plan);

/// Solves a scene with the elastic energy as accurately as is asked for. Where little is asked for, images
/// that sample the scene are solved until their differences say that a finer one is not needed; else the plan
/// is full multigrid and conjugate gradients until their steps say that it is enough. Throws InputError where
/// the scene has another energy, a figure of the request is not positive or the backend does not compute the
/// energy, and as ElasticSolver does. In the end the scene is as it was.
[[nodiscard]] Plan solve_as_needed(Scene& scene, const Request& request, const Backend& backend,
                                   const SessionOptions& options, Progress& progress);
/// Does the same on sessions that are open already.
[[nodiscard]] Plan solve_as_needed(Scene& scene, const Request& request, Solver& solver, Progress& progress);

} // namespace hdmbench
