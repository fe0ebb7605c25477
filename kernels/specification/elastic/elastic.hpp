#pragma once

#include "kernels/specification/language.hpp"

#include <cstddef>

namespace hdmbench {

/// The elastic energy of cells and what is done to sites (cell.inc, moments.inc, site.inc) for any scalar:
/// float is what devices compute, double is what tests follow. What comes after the texts has the same form
/// for images and for volumes; corners have numbers, x in the lowest bit, and moments the order of
/// CellMoments.
template <typename Scalar>
struct Elastic {
  using real = Scalar;
#define HDM_NUMBER(value) real(value)
#include "kernels/specification/elastic/cell.inc"
#include "kernels/specification/elastic/moments.inc"
#include "kernels/specification/elastic/site.inc"
#undef HDM_NUMBER

  /// nu with what follows from it, each rounded once. Volumes have lambda / mu and nothing else.
  struct Ratios : PoissonRatio {
    real lame;
  };
  static Ratios poisson_ratio(double nu) {
    return {{static_cast<real>(nu), static_cast<real>((1.0 - nu) / 2.0)},
            static_cast<real>(2.0 * nu / (1.0 - 2.0 * nu))};
  }

  static constexpr std::size_t axes = 2;
  static constexpr std::size_t moments = 6;

  template <typename At>
  HDM_FUNCTION CellMoments moments_of(const At& at) {
    return {at(0), at(1), at(2), at(3), at(4), at(5)};
  }
  template <typename At>
  HDM_FUNCTION CellCorners corners_of(const At& at) {
    return {at(0), at(1), at(2), at(3)};
  }
  /// take(component, corner, force) of all that a cell does to its corners, whose displacements are
  /// corners_of() displacement(component).
  template <typename Displacement, typename Take>
  HDM_FUNCTION void for_each_force(const CellMoments& cell, const Displacement& displacement,
                                   const Ratios& ratio, const Take& take) {
    const CellTension tension = cell_tension(cell, displacement(0), displacement(1), ratio);
    const auto take_both = [&](int corner, const Force& force) HDM_INLINED {
      take(0, corner, force.x);
      take(1, corner, force.y);
    };
    take_both(0, force_on_top_left(tension));
    take_both(1, force_on_top_right(tension));
    take_both(2, force_on_bottom_left(tension));
    take_both(3, force_on_bottom_right(tension));
  }
};

/// The same of volumes (volume.inc), with what is done to one component of a site (site.inc).
template <typename Scalar>
struct ElasticVolume : Elastic<Scalar> {
  using real = Scalar;
#define HDM_NUMBER(value) real(value)
#include "kernels/specification/elastic/volume.inc"
#undef HDM_NUMBER

  static constexpr std::size_t axes = 3;
  static constexpr std::size_t moments = 23;

  template <typename At>
  HDM_FUNCTION CellMoments moments_of(const At& at) {
    return {at(0),  at(1),  at(2),  at(3),  at(4),  at(5),   at(6),  at(7),  at(8),
            at(9),  at(10), at(11), at(12), at(13), at(14),  at(15), at(16), at(17),
            at(18), at(19), at(20), at(21), at(22), real(1), at(0)};
  }
  template <typename At>
  HDM_FUNCTION CellCorners corners_of(const At& at) {
    return {at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)};
  }
  template <typename Displacement, typename Take>
  HDM_FUNCTION void for_each_force(const CellMoments& cell, const Displacement& displacement,
                                   const typename Elastic<Scalar>::Ratios& ratio, const Take& take) {
    take_forces(cell_tension(cell, coefficients_of(displacement(0)), coefficients_of(displacement(1)),
                             coefficients_of(displacement(2)), ratio.lame),
                take);
  }
  /// The same of a cell that has one modulus.
  template <typename Displacement, typename Take>
  HDM_FUNCTION void for_each_force_of_uniform(real modulus, const Displacement& displacement,
                                              const typename Elastic<Scalar>::Ratios& ratio, real bend,
                                              const Take& take) {
    take_forces(uniform_tension(modulus, coefficients_of(displacement(0)), coefficients_of(displacement(1)),
                                coefficients_of(displacement(2)), ratio.lame, bend),
                take);
  }

private:
  template <typename Take>
  HDM_FUNCTION void take_forces(const CellTension& tension, const Take& take) {
    const auto take_corners = [&](int axis, const CellCorners& force) HDM_INLINED {
      take(axis, 0, force.c000);
      take(axis, 1, force.c100);
      take(axis, 2, force.c010);
      take(axis, 3, force.c110);
      take(axis, 4, force.c001);
      take(axis, 5, force.c101);
      take(axis, 6, force.c011);
      take(axis, 7, force.c111);
    };
    take_corners(0, forces_of(tension.x));
    take_corners(1, forces_of(tension.y));
    take_corners(2, forces_of(tension.z));
  }
};

/// As backends compute it.
using ElasticInFloat = Elastic<float>;
using VolumeInFloat = ElasticVolume<float>;

} // namespace hdmbench
