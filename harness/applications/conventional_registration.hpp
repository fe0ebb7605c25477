#pragma once

#include "harness/solve/progress.hpp"
#include "kernels/data/field.hpp"

namespace hdmbench {

struct ConventionalRegistration {
  VectorField displacement; ///< pixels; tissue at x of the source is at x + d(x) of the target
  double seconds = 0.0;
};

/// Finds d with target(x + d(x)) = source(x) as people do: Mattes mutual information, its gradient made
/// smooth by cubic B-splines, by ITK. Knows nothing of materials: where the source has no texture d is only
/// smooth. One thread, every pixel a sample: the same bits each time. Where `unseen` is not 0 it does not
/// look; empty: everywhere. Advances `progress` by 1. Throws InputError as require_pair does, where ITK gives
/// up, or the build has no ITK.
[[nodiscard]] ConventionalRegistration register_conventionally(const ScalarField& source,
                                                               const ScalarField& target,
                                                               const ScalarField& unseen, Progress& progress);

} // namespace hdmbench
