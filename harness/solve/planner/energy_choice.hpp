#pragma once

#include "harness/solve/planner/planner.hpp"

namespace hdmbench {

/// As solve_as_needed(), by the simpler energy that is enough: the accuracy is the distance from finite
/// elements with the scene's Poisson ratio. How far the thesis's energy ends from them is estimated on an
/// image that samples the scene, by solving it with both energies, and with what the elastic one's field
/// depends on that is thinner than a cell. Where that is at most a quarter of what is asked for, its
/// plan gets half, and its field has to end as near to the elastic one as that. Else, and where observations
/// are springs, the energy is the elastic one. The scene gets the energy that was chosen. Throws InputError
/// as solve_as_needed() does, or where no accuracy is asked for.
[[nodiscard]] Plan solve_by_either_energy(Scene& scene, const Request& request, const Backend& backend,
                                          const SessionOptions& options,
                                          std::vector<std::unique_ptr<Session>>& sessions,
                                          Progress& progress);

} // namespace hdmbench
