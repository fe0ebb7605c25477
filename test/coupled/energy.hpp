#pragma once

#include "kernels/specification/language.hpp"

namespace hdmbench {

/// The energy of energy.inc beside this file, as kernels/specification/hdm/energy.hpp has the thesis's.
template <typename Scalar, int axes = 2>
struct Coupled;

#define HDM_INPUTS 1
#define HDM_ENERGY_TEXT "test/coupled/energy.inc"
template <typename Scalar>
struct Coupled<Scalar, 2> {
  using real = Scalar;
#define HDM_AXES 2
#include "kernels/specification/members.inc"
#undef HDM_AXES
};
template <typename Scalar>
struct Coupled<Scalar, 3> {
  using real = Scalar;
#define HDM_AXES 3
#include "kernels/specification/members.inc"
#undef HDM_AXES
};
#undef HDM_ENERGY_TEXT
#undef HDM_INPUTS

} // namespace hdmbench
