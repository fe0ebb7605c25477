#pragma once

#include "backends/backend.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/solve.hpp"

namespace hdmbench {

/// How far a registration is to be believed, per site and component, 0 ... 1. Two things speak for it: the
/// gradients of the source around, along that component, against what noise alone would make (structure
/// tensor), and that the pictures look the same after it. 0 where `unseen` is not 0: the region of interest.
/// Below 1 everywhere: nothing that was measured is certain.
[[nodiscard]] VectorField confidence_of(const ScalarField& source, const ScalarField& target,
                                        const VectorField& displacement, const ScalarField& unseen);

/// Thesis Algorithm 5: `displacement` of a conventional registration, believed where it deserves it
/// (confidence_of), is what is observed; the scene's moduli, its energy and its method decide about the rest.
/// Where the pictures do not match inside `unseen` (the region) its moduli count less.
/// Returns the solution and, in `confidence`, what was believed. Throws what Solver throws.
[[nodiscard]] Solution make_physical(const ScalarField& source, const ScalarField& target,
                                     const VectorField& displacement, const ScalarField& unseen,
                                     const Scene& scene, const Backend& backend,
                                     const SessionOptions& session, VectorField& confidence,
                                     Progress& progress);

} // namespace hdmbench
