#pragma once

#include "harness/scene/method.hpp"

#include <string>
#include <vector>

namespace hdmbench {

/// The settings a method is measured at, rising, its usual effort among them unless quick: what --iterations
/// takes. `own_iterations` are the scene's, the usual effort of the methods that have none. With `quick` the
/// two smallest.
[[nodiscard]] std::vector<int> efforts(const Method& method, int own_iterations, bool quick);

/// "4 cycles", "1 iteration on the full resolution".
[[nodiscard]] std::string effort_text(const Method& method, int effort);

/// The effort on every backend: the method's usual one or the scene's, less for annealing.
[[nodiscard]] int usual_effort(const Method& method, int own_iterations);

} // namespace hdmbench
