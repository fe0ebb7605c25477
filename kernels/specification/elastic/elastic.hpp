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

/// The same of volumes (volume.inc), with what is done to one component of a site (site.inc).
template <typename Scalar>
struct ElasticVolume : Elastic<Scalar> {
  using real = Scalar;
#define HDM_NUMBER(value) real(value)
#include "kernels/specification/elastic/volume.inc"
#undef HDM_NUMBER

  /// lambda / mu: volumes have no other number of nu.
  static real lame_ratio(double nu) {
    return static_cast<real>(2.0 * nu / (1.0 - 2.0 * nu));
  }
};

/// As backends compute it.
using ElasticInFloat = Elastic<float>;
using VolumeInFloat = ElasticVolume<float>;

} // namespace hdmbench
