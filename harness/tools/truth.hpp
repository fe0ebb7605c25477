#pragma once

#include "kernels/data/field.hpp"

namespace hdmbench {

/// What a solution is measured against.
struct Truth {
  VectorField displacement; ///< pixels
  ScalarField defined;      ///< not 0 where the truth is known; empty: everywhere
};

/// (5.1) over the sites where the truth is defined, pixels. Throws InputError where the sizes differ or the
/// truth is defined nowhere.
[[nodiscard]] double rmsd(const VectorField& displacement, const Truth& truth);

} // namespace hdmbench
