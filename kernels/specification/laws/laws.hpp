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
  using typename Volume::CellTension;
  using typename Volume::Coefficients;
#define HDM_NUMBER(value) real(value)
#define HDM_STRUCT(name)
#define HDM_BITS_LESS(number, x) language::bits_less(number, x)
// In this order: each needs what stands before it.
#include "kernels/specification/laws/reciprocal.inc"
#include "kernels/specification/laws/strain.inc"
#include HDMBENCH_LAW_TEXT
#include "kernels/specification/laws/cell.inc"
#include "kernels/specification/laws/fibres.inc"
#include "kernels/specification/laws/stress.inc"
#undef HDM_BITS_LESS
#undef HDM_STRUCT
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
    const auto stress = [&](int corner, const Gradient& h) HDM_INLINED {
      return with_fibre(stress_of(tissue(corner), h), fibre(corner), h);
    };
    const Stresses stresses{stress(0, at.p000), stress(1, at.p100), stress(2, at.p010), stress(3, at.p110),
                            stress(4, at.p001), stress(5, at.p101), stress(6, at.p011), stress(7, at.p111)};
    Volume::take_forces(tension_of_stresses(stresses, sides), take);
    const auto share = [&](int corner, const Gradient& h)
                           HDM_INLINED { return share_left(tissue(corner), h); };
    return lesser(
        lesser(lesser(share(0, at.p000), share(1, at.p100)), lesser(share(2, at.p010), share(3, at.p110))),
        lesser(lesser(share(4, at.p001), share(5, at.p101)), lesser(share(6, at.p011), share(7, at.p111))));
  }
};

} // namespace hdmbench::laws::HDMBENCH_LAW
