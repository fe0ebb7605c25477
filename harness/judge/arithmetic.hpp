#pragma once

#include "backends/backend.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <nlohmann/json.hpp>

#include <cstdint>

namespace hdmbench {

/// Iterations in float32 against one in double from the same field, over a scene's schedule. A step is one
/// component of one site in one iteration.
struct ArithmeticError {
  std::int64_t steps_compared = 0;
  std::int64_t steps_differing = 0; ///< another candidate than in double
  std::int64_t beyond_bound = 0;    ///< of these, not explained by the derived bound of rounding; 0 is right
  double largest_gap_over_bound =
      0.0; ///< exact energy lost by the choice, over its bound; at most 1 is right
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ArithmeticError, steps_compared, steps_differing, beyond_bound,
                                   largest_gap_over_bound)

/// Of a backend's run of the scene. Of every level the first five iterations are compared, and then every
/// `stride`-th. Throws InputError where the scene's method is not icm, and what Session throws.
[[nodiscard]] ArithmeticError measure_arithmetic(const Scene& scene, const Backend& backend,
                                                 const SessionOptions& options, int stride,
                                                 Progress& progress);

} // namespace hdmbench
