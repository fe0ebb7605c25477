#pragma once

#include "kernels/data/field.hpp"

namespace hdmbench {

/// `source` with gray values as `target` has them, which shows the same at the same sites: each bin of gray
/// values of the source becomes the mean that the target has there, linear between bins. Two scanners, or
/// one on two days, do not give one tissue one value. Where `unseen` is not 0 the two do not show the same;
/// empty: nowhere.
[[nodiscard]] ScalarField with_values_of(const ScalarField& source, const ScalarField& target,
                                         const ScalarField& unseen);

} // namespace hdmbench
