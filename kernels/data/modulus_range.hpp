#pragma once

#include "kernels/data/field.hpp"

namespace hdmbench {

/// MPa
struct ModulusRange {
  double softest = 0.0;
  double stiffest = 0.0;
};

/// Of moduli > 0. Of none: the largest float and 0, which other parts of an image change.
[[nodiscard]] ModulusRange modulus_range(const ScalarField& modulus);

/// The stiffest over the softest of an image's moduli, which are > 0. >= 1
[[nodiscard]] inline double contrast_of(const ScalarField& modulus) {
  const ModulusRange range = modulus_range(modulus);
  return range.stiffest / range.softest;
}

} // namespace hdmbench
