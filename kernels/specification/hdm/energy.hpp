#pragma once

#include "kernels/specification/language.hpp"

namespace hdmbench {

/// The thesis's energy and the moves of a site (site.inc, hdm/energy.inc, update.inc) for any scalar: float
/// is what devices compute, others follow rounding, prove exactness or count. In an image, or in a volume of
/// three axes.
template <typename Scalar, int axes = 2>
struct Hdm;

#define HDM_INPUTS 0
#define HDM_ENERGY_TEXT "kernels/specification/hdm/energy.inc"
template <typename Scalar>
struct Hdm<Scalar, 2> {
  using real = Scalar;
#define HDM_AXES 2
#include "kernels/specification/members.inc"
#undef HDM_AXES
};
template <typename Scalar>
struct Hdm<Scalar, 3> {
  using real = Scalar;
#define HDM_AXES 3
#include "kernels/specification/members.inc"
#undef HDM_AXES
};
#undef HDM_ENERGY_TEXT
#undef HDM_INPUTS

/// The arithmetic of backends.
using HdmInFloat = Hdm<float>;

} // namespace hdmbench
