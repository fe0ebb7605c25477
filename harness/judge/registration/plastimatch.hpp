#pragma once

#include "kernels/data/field.hpp"

namespace hdmbench {

/// Whether the program plastimatch is on PATH and starts, and this build writes the images that it takes.
[[nodiscard]] bool have_plastimatch();

/// What plastimatch's B-splines make of a pair of volumes.
struct PlastimatchRegistration {
  VectorField
      displacement;     ///< of the source to the target, pixels: the inverse of its field, which leads back
  double seconds = 0.0; ///< from its start to its end, with its files
};

/// Registers volumes of cubes of `spacing` mm, by squared differences and B-splines of 40, then 20, then 10
/// mm. Throws InputError with the program's words where it fails.
[[nodiscard]] PlastimatchRegistration register_by_plastimatch(const ScalarField& source,
                                                              const ScalarField& target, double spacing);

} // namespace hdmbench
