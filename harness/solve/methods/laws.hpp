#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/solve.hpp"

#include <functional>

namespace hdmbench {

/// How near to the end a solution by laws is taken where nobody says, pixels, RMS.
inline constexpr double usual_law_accuracy = 0.01;

/// What the solution by laws says on its way.
struct LawStep {
  Extent extent;      ///< the image of it
  double error = 0.0; ///< that is left by estimate, pixels of the full resolution; infinite: not known yet
  double moved = 0.0; ///< by the cycle before, RMS, pixels of the full resolution
  /// Whether the cycle begins with the linear solution: `moved` then is about how far that is from what the
  /// law has, mostly within 2.5 times.
  bool of_linear = false;
  double smallest = 0.0; ///< share of its volume that a cell has kept
};

/// Returns the displacement of a scene whose tissues have laws of large strains (kernels/specification/laws),
/// within so many pixels of its end. Takes non-linear conjugate gradients on images of half, a quarter, ...
/// as many sites a side and on the image itself; the cycle of the linear energy on `session` is their
/// preconditioner, and the forces of the laws are the host's, so that all sessions have the same bits. Where
/// it ends without an answer, Solution::failure says why. Throws as ElasticSolver does.
[[nodiscard]] Solution solve_by_laws(const Scene& scene, ElasticSession& session, double accuracy,
                                     const std::function<void(const LawStep&)>& say);

} // namespace hdmbench
