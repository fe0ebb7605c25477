#pragma once

#include "kernels/field.hpp"
#include "kernels/step_set.hpp"

namespace hdmbench {

/// In which order one iteration visits the sites.
enum class Update {
  simultaneous, ///< all sites read the old field and write the new one: the design for GPUs
  sequential,   ///< raster order, in place: the thesis's CPU design
};

/// One level of the pyramid: all that a sweep reads and does not write.
struct Level {
  Extent extent;
  VectorField target{};          ///< y, pixels of the full resolution image
  VectorField confidence{};      ///< c in [0, 1] per component, 0 = unknown
  ScalarField modulus{};         ///< m > 0, MPa
  ScalarField inverse_modulus{}; ///< 1 / m rounded to float
  float penalty = 1.0F;          ///< K > 0
  StepSet steps{};
  Update update = Update::simultaneous;
};

/// Fills inverse_modulus from modulus.
void set_inverse_modulus(Level& level);

/// Throws InputError naming the field and the first offending site: a size that does not match the extent, a
/// value that is not finite, modulus <= 0 or without a finite inverse, confidence outside [0, 1], K <= 0.
void validate(const Level& level);

/// Throws InputError where a component is not finite or the size is not `extent`; `what` names the field.
void validate(const VectorField& field, Extent extent, const char* what);

} // namespace hdmbench
