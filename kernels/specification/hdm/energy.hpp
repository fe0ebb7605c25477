#pragma once

#include "kernels/specification/language.hpp"

namespace hdmbench {

/// The thesis's energy and the moves of a site (site.inc, hdm/energy.inc, update.inc) for any scalar: float
/// is what devices compute, others follow rounding, prove exactness or count.
template <typename Scalar>
struct Hdm {
  using real = Scalar;
#define HDM_INPUTS 0
#define HDM_ENERGY_TEXT "kernels/specification/hdm/energy.inc"
#include "kernels/specification/members.inc"
#undef HDM_ENERGY_TEXT
#undef HDM_INPUTS
};

/// As backends compute it.
using HdmInFloat = Hdm<float>;

} // namespace hdmbench
