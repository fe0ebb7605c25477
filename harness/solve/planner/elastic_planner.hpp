#pragma once

#include "harness/solve/planner/planner.hpp"

namespace hdmbench {

/// As solve_as_needed(), of a scene with the elastic energy: full multigrid, then conjugate gradients until
/// the steps say that the distance from finite elements with the scene's Poisson ratio is within what is
/// asked for. Throws InputError as ElasticSolver does, or where the backend does not compute this energy.
[[nodiscard]] Plan solve_elastic_as_needed(const Scene& scene, const Request& request, const Backend& backend,
                                           const SessionOptions& options, Progress& progress);

} // namespace hdmbench
