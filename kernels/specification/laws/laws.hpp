#pragma once

#include "kernels/specification/elastic/elastic.hpp"

/// Which law, and the file of its text: what a further one defines.
#ifndef HDMBENCH_LAW
#define HDMBENCH_LAW neo_hookean
#define HDMBENCH_LAW_TEXT "kernels/specification/laws/neo_hookean.inc"
#endif

namespace hdmbench::laws::HDMBENCH_LAW {

/// Tissue that has the law, or is linear, and the cells that it is in (cell.inc) for any scalar. An image is
/// a layer of cells.
template <typename Scalar>
struct Laws : ElasticVolume<Scalar, true> {
  using real = Scalar;
  using Volume = ElasticVolume<Scalar, true>;
  using typename Volume::Coefficients;
#define HDM_NUMBER(value) real(value)
// In this order: each needs what stands before it.
#include "kernels/specification/laws/strain.inc"
#include HDMBENCH_LAW_TEXT
#include "kernels/specification/laws/cell.inc"
#include "kernels/specification/laws/fibres.inc"
#include "kernels/specification/laws/stress.inc"
#undef HDM_NUMBER

  /// A tissue without fibres.
  struct NoFibre {};
  HDM_FUNCTION Stress with_fibre(const Stress& stress, NoFibre /*none*/, const Gradient& /*h*/) {
    return stress;
  }

  /// Calls take(axis, corner, force) with what a cell does to its corners, whose displacements are
  /// `displacement`(axis), whose tissues `tissue`(corner) and whose fibres `fibre`(corner), and returns the
  /// least share of its volume that is left at a Gauss point of tissue with a law of large strains, at most 1
  /// where some is linear.
  template <typename Displacement, typename TissueAt, typename FibreAt, typename Take>
  HDM_FUNCTION real for_each_force_by_law(const Displacement& displacement, const TissueAt& tissue,
                                          const FibreAt& fibre, Sides sides, const Take& take) {
    const Gradients at = gradients_of(slopes_at_points(Volume::coefficients_of(displacement(0)), sides),
                                      slopes_at_points(Volume::coefficients_of(displacement(1)), sides),
                                      slopes_at_points(Volume::coefficients_of(displacement(2)), sides));
    const Stress s000 = with_fibre(stress_of(tissue(0), at.p000), fibre(0), at.p000);
    const Stress s100 = with_fibre(stress_of(tissue(1), at.p100), fibre(1), at.p100);
    const Stress s010 = with_fibre(stress_of(tissue(2), at.p010), fibre(2), at.p010);
    const Stress s110 = with_fibre(stress_of(tissue(3), at.p110), fibre(3), at.p110);
    const Stress s001 = with_fibre(stress_of(tissue(4), at.p001), fibre(4), at.p001);
    const Stress s101 = with_fibre(stress_of(tissue(5), at.p101), fibre(5), at.p101);
    const Stress s011 = with_fibre(stress_of(tissue(6), at.p011), fibre(6), at.p011);
    const Stress s111 = with_fibre(stress_of(tissue(7), at.p111), fibre(7), at.p111);
    const auto all = [&](real Stress::*part) HDM_INLINED {
      return AtPoints{s000.*part, s100.*part, s010.*part, s110.*part,
                      s001.*part, s101.*part, s011.*part, s111.*part};
    };
    const auto tension = [&](const AtPoints& x, const AtPoints& y, const AtPoints& z)
                             HDM_INLINED { return tension_of_points(x, y, z, sides); };
    Volume::take_forces({tension(all(&Stress::xx), all(&Stress::xy), all(&Stress::xz)),
                         tension(all(&Stress::yx), all(&Stress::yy), all(&Stress::yz)),
                         tension(all(&Stress::zx), all(&Stress::zy), all(&Stress::zz))},
                        take);
    // Linear tissue counts as if it kept all: its law has an answer for cells that are turned over, too.
    const auto volume = [&](int corner, const Gradient& h) HDM_INLINED {
      return tissue(corner).parameter < real(0) ? real(1) : real(1) + dilation_of(h, cofactors_of(h));
    };
    const auto least = [](real a, real b) HDM_INLINED { return b < a ? b : a; };
    return least(
        least(least(volume(0, at.p000), volume(1, at.p100)), least(volume(2, at.p010), volume(3, at.p110))),
        least(least(volume(4, at.p001), volume(5, at.p101)), least(volume(6, at.p011), volume(7, at.p111))));
  }
};

} // namespace hdmbench::laws::HDMBENCH_LAW
