#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/solve.hpp"

#include <cstddef>
#include <functional>
#include <optional>

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

/// How far the linear solution of a level is from what its laws have.
struct LinearDistance {
  double pixels = 0.0;   ///< RMS, by what a cycle makes of the forces of the laws: mostly within 2.5 times
  double smallest = 0.0; ///< share of its volume that a cell has kept
  bool buckles = false;  ///< by laws, so that nothing is known of the distance
};

/// A distance that is larger than this share of what is good enough is taken for too large: LinearDistance is
/// up to 2.5 times too low, where thin layers differ a thousandfold.
inline constexpr double believed_share_of_distance = 0.4;
/// Below it a linear solution is so far from what laws have that a cycle says nothing of the distance.
inline constexpr double least_of_linear = 0.2;

/// Returns the distance of a displacement that is the linear solution of `level`, whose cycle `linear` has;
/// what that solves has no meaning afterwards. Nothing but conditions may move the level.
[[nodiscard]] LinearDistance distance_of_linear(const Level& level, const ElasticModel& model,
                                                const VectorField& solution, ElasticSolver& linear);

/// Returns the site around which a thin layer wrinkles under a displacement, as conjugate gradients see it on
/// the part of the image where layers are pressed most (place_that_may_wrinkle()); none: nowhere. The session
/// then has the body of that part, and the time is added to that of `solution`.
[[nodiscard]] std::optional<std::size_t> site_that_wrinkles(const Level& level, const ElasticModel& model,
                                                            ElasticSession& session,
                                                            const VectorField& displacement,
                                                            Solution& solution);

/// Returns a displacement, given in pixels whose side is `from`, in such of the side `to`.
[[nodiscard]] VectorField in_other_pixels(VectorField displacement, double from, double to);

/// Makes pixels of `sampled`, an image with the sites of `full` at its ends and the targets of it, its own:
/// laws know how large a strain is. Returns how many pixels of `full` one is.
double take_own_pixels(Level& sampled, const Level& full);

/// Returns the displacement of an image or a volume whose tissues have laws of large strains
/// (kernels/specification/laws), within so many pixels of its end. Takes non-linear conjugate gradients on
/// images of half, a quarter, ... as many sites a side and on the image itself; the cycle of the linear
/// energy on `session` is their preconditioner, and the forces of the laws are the host's to the bit, so that
/// all sessions have the same field. Where a cell is then pressed together farther than laws hold, it goes
/// nearer to the end before that is said. What conditions hold around the rest is cut off (Solution::part).
/// Where it ends without an answer, Solution::failure says why. Throws as ElasticSolver does.
[[nodiscard]] Solution solve_by_laws(const Level& level, const ElasticModel& model, ElasticSession& session,
                                     double accuracy, const std::function<void(const LawStep&)>& say);

} // namespace hdmbench
