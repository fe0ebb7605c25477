#pragma once

#include "harness/scene/method.hpp"

#include <string>
#include <vector>

namespace hdmbench {

/// What a method is told to do.
struct Effort {
  int iterations = 0; ///< what --iterations takes
  int stride = 1;     ///< what --stride takes
};

/// The settings a method is measured at on an image, rising, its usual effort among them unless quick.
/// `own_iterations` are the scene's, the usual effort of the methods that have none. With `quick` the two
/// smallest on the full resolution; else full multigrid also solves sampled images, the coarsest first.
[[nodiscard]] std::vector<Effort> efforts(const Method& method, int own_iterations, Extent image, bool quick);

/// "4 cycles", "1 iteration on the full resolution", "2 cycles on every 8th pixel".
[[nodiscard]] std::string effort_text(const Method& method, Effort effort);

/// The effort on every backend: the method's usual one or the scene's, less for annealing.
[[nodiscard]] int usual_effort(const Method& method, int own_iterations);

} // namespace hdmbench
