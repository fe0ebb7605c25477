#pragma once

#include "kernels/specification/language.hpp"

#include <array>
#include <cstddef>

namespace hdmbench {

/// nu with what follows from it, and the factors of slopes, each rounded once. The Law of images is nu, shear
/// and y, that of volumes lame, y and z.
template <typename Scalar>
struct ElasticRatios {
  Scalar nu{};
  Scalar shear{};
  Scalar lame{};
  Scalar y{1};
  Scalar z{1};

  /// `sides` of a pixel or a voxel: only what they are to each other counts.
  static ElasticRatios of(double nu, const std::array<double, 3>& sides = {1.0, 1.0, 1.0}) {
    return {static_cast<Scalar>(nu), static_cast<Scalar>((1.0 - nu) / 2.0),
            static_cast<Scalar>(2.0 * nu / (1.0 - 2.0 * nu)), static_cast<Scalar>(sides[0] / sides[1]),
            static_cast<Scalar>(sides[0] / sides[2])};
  }
  /// The same numbers for another scalar.
  template <typename Other>
  [[nodiscard]] ElasticRatios<Other> as() const {
    return {Other(nu), Other(shear), Other(lame), Other(y), Other(z)};
  }
  /// Whether the texts need the factors.
  [[nodiscard]] bool has_boxes() const { return !(y == Scalar(1)) || !(z == Scalar(1)); }
};

/// The elastic energy of cells and what is done to sites (cell.inc, moments.inc, site.inc) for any scalar:
/// float is what devices compute, double is what tests follow. What comes after the texts has the same form
/// for images and for volumes; corners have numbers, x in the lowest bit, and moments the order of
/// CellMoments. `boxes`: HDM_BOXES.
template <typename Scalar, bool boxes = false>
struct Elastic {
  using real = Scalar;
  using Ratios = ElasticRatios<Scalar>;
#define HDM_NUMBER(value) real(value)
#define HDM_BOXES boxes
#include "kernels/specification/elastic/cell.inc"
#include "kernels/specification/elastic/moments.inc"
#include "kernels/specification/elastic/site.inc"
#undef HDM_BOXES
#undef HDM_NUMBER

  HDM_FUNCTION Law law_of(const Ratios& ratios) {
    return {ratios.nu, ratios.shear, ratios.y};
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
    const Law law = law_of(ratio);
    const CellTension tension = cell_tension(cell, displacement(0), displacement(1), law);
    const auto take_both = [&](int corner, const Force& force) HDM_INLINED {
      take(0, corner, force.x);
      take(1, corner, force.y);
    };
    take_both(0, force_on_top_left(tension, law));
    take_both(1, force_on_top_right(tension, law));
    take_both(2, force_on_bottom_left(tension, law));
    take_both(3, force_on_bottom_right(tension, law));
  }
};

/// The same of volumes (volume.inc), with what is done to one component of a site (site.inc).
template <typename Scalar, bool boxes = false>
struct ElasticVolume : Elastic<Scalar, boxes> {
  using real = Scalar;
  using Ratios = ElasticRatios<Scalar>;
#define HDM_NUMBER(value) real(value)
#define HDM_BOXES boxes
#include "kernels/specification/elastic/volume.inc"
#undef HDM_BOXES
#undef HDM_NUMBER

  HDM_FUNCTION Law law_of(const Ratios& ratios) {
    return {ratios.lame, ratios.y, ratios.z};
  }

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
                                   const Ratios& ratio, const Take& take) {
    take_forces(cell_tension(cell, coefficients_of(displacement(0)), coefficients_of(displacement(1)),
                             coefficients_of(displacement(2)), law_of(ratio)),
                take);
  }
  /// The same of a cell that has one modulus.
  template <typename Displacement, typename Take>
  HDM_FUNCTION void for_each_force_of_uniform(real modulus, const Displacement& displacement,
                                              const Ratios& ratio, real bend, const Take& take) {
    take_forces(uniform_tension(modulus, coefficients_of(displacement(0)), coefficients_of(displacement(1)),
                                coefficients_of(displacement(2)), law_of(ratio), bend),
                take);
  }

protected:
  /// Calls take(axis, corner, force) with what a tension does to the corners.
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

/// The arithmetic of backends.
using ElasticInFloat = Elastic<float>;
using VolumeInFloat = ElasticVolume<float>;

} // namespace hdmbench
