#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/solve.hpp"

namespace hdmbench {

/// The springs of `full` (kernels/data/elastic/springs.hpp) as stiff as they count at `displacement`: a site
/// whose observation is r pixels away counts 1 / sqrt(1 + (r / forgiven)^2). So the energy of a spring,
/// stiffness times forgiven^2 (sqrt(1 + (r / forgiven)^2) - 1), grows with the square of a way below
/// `forgiven` and in proportion to one above: an absolute value. It is convex, with one minimum.
/// Prescribed components stay.
[[nodiscard]] Level reweighted(const Level& full, const VectorField& displacement, double forgiven);

/// What robust observations come to.
struct RobustObservations {
  Level level{};      ///< scene.full with the springs as they count in the end
  int rounds = 0;     ///< solutions that it took
  double moved = 0.0; ///< by the last of them, RMS, pixels
  Timings timings{};
  std::vector<LevelResult> work{}; ///< of all rounds, the image first
};

/// Sweeps and residuals of the same levels; an empty sum has none yet.
void add_work(std::vector<LevelResult>& sum, const std::vector<LevelResult>& more);

/// Iteratively reweighted least squares: solves, to a fiftieth of scene.robust, and weighs anew until a round
/// moves the field by less than a thousandth of it (RMS), at most 50 times. Throws InputError where the scene
/// has no springs, or as ElasticSolver does.
[[nodiscard]] RobustObservations find_robust_observations(const Scene& scene, ElasticSession& session,
                                                          Progress& progress);

} // namespace hdmbench
