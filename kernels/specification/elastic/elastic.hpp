#pragma once

#include "kernels/specification/language.hpp"

namespace hdmbench {

/// The elastic energy of cells and what is done to sites (cell.inc, moments.inc, site.inc) for any scalar:
/// float is what devices compute, double is what tests follow.
template <typename Scalar>
struct Elastic {
  using real = Scalar;
#define HDM_NUMBER(value) real(value)
#include "kernels/specification/elastic/cell.inc"
#include "kernels/specification/elastic/moments.inc"
#include "kernels/specification/elastic/site.inc"
#undef HDM_NUMBER

  /// nu with what follows from it, each rounded once.
  static PoissonRatio poisson_ratio(double nu) {
    return {static_cast<real>(nu), static_cast<real>((1.0 - nu) / 2.0)};
  }
};

/// As backends compute it.
using ElasticInFloat = Elastic<float>;

} // namespace hdmbench
