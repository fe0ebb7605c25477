#pragma once

#include "kernels/data/field.hpp"

namespace hdmbench {

/// The stiffest over the softest of an image's moduli, which are > 0. >= 1
[[nodiscard]] double contrast_of(const ScalarField& modulus);

} // namespace hdmbench
