#pragma once

#include "reference/finite_elements.hpp"

#include <complex>

namespace hdmbench {

/// An infinite sheet in plane stress with a round inclusion of another modulus, pulled from far away along x:
/// the displacement is known in closed form. Lengths are pixels, the centre of the inclusion is 0.
///
/// With Muskhelishvili's potentials, 2 mu (u + i v) = kappa phi - z conj(phi') - conj(psi), where
/// kappa = (3 - nu) / (1 + nu). Outside they are S / 4 (z + A a^2 / z) and -S / 2 (z + B a^2 / z + C a^4 /
/// z^3), inside S / 4 D z and -S / 2 F z; displacement and traction are the same on both sides of |z| = a.
/// The stress inside is uniform (N. I. Muskhelishvili, Some Basic Problems of the Mathematical Theory of
/// Elasticity, 1953; J. N. Goodier, J. Appl. Mech. 1, 1933; J. D. Eshelby, Proc. R. Soc. A 241, 1957);
/// modulus_inside = 0 is a hole (G. Kirsch, Z. VDI 42, 1898).
class CircularInclusion {
public:
  struct Parameters {
    double radius = 1.0;          ///< a
    double modulus_inside = 1.0;  ///< Young's modulus, MPa, >= 0
    double modulus_outside = 1.0; ///< > 0
    double poisson = 0.3;         ///< nu of both, as a scene has one
    double stretch = 0.01;        ///< strain xx far away, S / modulus_outside
  };
  struct Stress {
    double xx;
    double yy;
    double xy;
  };

  /// Throws InputError for a length or modulus out of range.
  explicit CircularInclusion(const Parameters& parameters);

  [[nodiscard]] bool is_inside(std::complex<double> z) const { return std::abs(z) < parameters_.radius; }
  /// u + i v, pixels. On the circle that of the outside.
  [[nodiscard]] std::complex<double> displacement(std::complex<double> z) const;
  /// MPa. On the circle that of the outside.
  [[nodiscard]] Stress stress(std::complex<double> z) const;

  /// `side` x `side` nodes around the centre: the modulus of every pixel is that of its middle, the border
  /// has the exact displacement. `prescribed` is exact inside, too.
  [[nodiscard]] ElasticProblem on_pixels(int side) const;

private:
  struct Potentials {
    std::complex<double> phi, phi_slope, phi_curvature, psi, psi_slope; ///< phi', phi'', psi'
  };
  [[nodiscard]] Potentials potentials(std::complex<double> z) const;

  Parameters parameters_;
  double a_ = 0.0; ///< A ... F of the equations above
  double b_ = 0.0;
  double c_ = 0.0;
  double d_ = 1.0;
  double f_ = 1.0;
};

} // namespace hdmbench
