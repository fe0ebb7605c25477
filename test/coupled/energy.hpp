#pragma once

#include "kernels/specification/language.hpp"

namespace hdmbench {

/// The energy of energy.inc beside this file, as kernels/specification/hdm/energy.hpp has the thesis's.
template <typename Scalar>
struct Coupled {
  using real = Scalar;
#define HDM_INPUTS 1
#define HDM_ENERGY_TEXT "test/coupled/energy.inc"
#include "kernels/specification/members.inc"
#undef HDM_ENERGY_TEXT
#undef HDM_INPUTS
};

} // namespace hdmbench
