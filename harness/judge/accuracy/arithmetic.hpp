#pragma once

#include "backends/backend.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "reference/interpolation.hpp"

#include <cstdint>

namespace hdmbench {

/// One iteration in float32 against one in double from the same field, over many iterations of a scene's
/// schedule. A step is one component of one site in one iteration.
struct ArithmeticError {
  std::int64_t iterations = 0; ///< compared
  std::int64_t steps_compared = 0;
  std::int64_t steps_differing = 0; ///< another candidate than in double
  std::int64_t beyond_bound = 0;    ///< of these, not explained by the derived bound of rounding; 0 is right
  double largest_gap_over_bound =
      0.0;                  ///< exact energy lost by the choice, over its bound; at most 1 is right
  double squared_sum = 0.0; ///< px^2 over all sites and iterations

  /// Root mean square distance of the two results of one iteration, pixels.
  [[nodiscard]] double rmsd() const;
};

/// Of a backend's run of the scene. Of every level the first five iterations are compared, and then every
/// `stride`-th. Throws InputError where the scene's method is not icm, and what Session throws.
[[nodiscard]] ArithmeticError measure_arithmetic(const Scene& scene, const Backend& backend,
                                                 const SessionOptions& options, int stride,
                                                 Progress& progress);

/// The scene's schedule (simultaneous, a fixed number of iterations) in double from begin to end.
[[nodiscard]] ReferenceField solve_in_double(const Scene& scene, Progress& progress);

} // namespace hdmbench
