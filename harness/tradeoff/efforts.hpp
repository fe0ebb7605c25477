#pragma once

#include "harness/methods/method.hpp"

#include <vector>

namespace hdmbench {

/// The settings a method is measured at, rising, its usual effort among them: what --iterations takes.
/// `own_iterations` are the scene's, the usual effort of the methods that have none. With `quick` the usual
/// effort and a smaller one.
[[nodiscard]] std::vector<int> efforts(const Method& method, int own_iterations, bool quick);

/// Iterations where neither the scene nor the method says less.
[[nodiscard]] int usual_effort(const Method& method, int own_iterations);

} // namespace hdmbench
