#pragma once

#include "kernels/energy_macros.hpp"

/// energy.inc, update.inc and projection.inc in float as C++: Site, Displacement, improved_displacement(),
/// site_energy(), swept_displacement(), projected(). All of it has internal linkage, so that translation
/// units built for different instruction sets cannot be mixed up by the linker.
namespace hdmbench::energy {

using real = float;

HDM_FUNCTION real abs(real value) {
  return __builtin_fabsf(value);
}

/// update.inc asks for numbers 0 <= value < 2^24 only: truncation, for which every processor has an
/// instruction.
HDM_FUNCTION real floor(real value) {
  return static_cast<real>(static_cast<int>(value));
}

#include "kernels/energy.inc"
#include "kernels/projection.inc"
#include "kernels/update.inc"

} // namespace hdmbench::energy
