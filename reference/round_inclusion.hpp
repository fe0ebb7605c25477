#pragma once

#include "reference/finite_elements.hpp"

namespace hdmbench {

/// An infinite sheet in plane stress with a round inclusion of another modulus, or an infinite body with a
/// ball, pulled from far away along x: the displacement is known in closed form. Lengths are pixels or
/// voxels, the centre of the inclusion is 0.
///
/// With d = 2 or 3 axes, the strain far away is e + D, e its mean and D without trace, q = x' D x and
/// p = 2 mu / (lambda + mu). Outside, with the Papkovich-Neuber potential D x / r^d and the gradient of
/// q / r^(d + 2),
///   u = e x + B x a^d / r^d + D x + c a^d (p D x / r^d + d q x / r^(d+2))
///       + c d / (d + 2) a^(d+2) (2 D x / r^(d+2) - (d + 2) q x / r^(d+4)),
/// inside u = (e + B) x + (1 + c m) D x: displacement and traction are the same on both sides of r = a with
///   B = e k (1 - g) / (g k + 2 (d - 1)), k = d lambda / mu + 2, c = (1 - g) / (h + g m),
///   m = p + 2 d / (d + 2), h = p (d - 2) / 2 + d^2 / (d + 2), g = modulus_inside / modulus_outside.
/// The strain inside is uniform (J. N. Goodier, J. Appl. Mech. 1, 1933; J. D. Eshelby, Proc. R. Soc. A 241,
/// 1957); modulus_inside = 0 is a hole (G. Kirsch, Z. VDI 42, 1898).
class RoundInclusion {
public:
  struct Parameters {
    double radius = 1.0;          ///< a
    double modulus_inside = 1.0;  ///< Young's modulus, MPa, >= 0
    double modulus_outside = 1.0; ///< > 0
    double poisson = 0.3;         ///< nu of both, as a scene has one
    double stretch = 0.01;        ///< strain xx far away; the other normal strains are -nu times it
    std::size_t axes = 2;         ///< d
  };

  /// Throws InputError for a length or modulus out of range.
  explicit RoundInclusion(const Parameters& parameters);

  [[nodiscard]] double modulus(const Point& at) const;
  /// On the circle or sphere both sides' is the same.
  [[nodiscard]] Point displacement(const Point& at) const;

  /// `side` nodes along every axis around the centre: the modulus of every site is that of its middle, the
  /// outermost nodes have the exact displacement. `prescribed` is exact inside, too.
  [[nodiscard]] ElasticProblem on_sites(int side) const;

private:
  [[nodiscard]] double square_distance(const Point& at) const; ///< (r / a)^2

  Parameters parameters_;
  double p_ = 0.0; ///< p, m, B / e and c of the equations above
  double m_ = 0.0;
  double b_ = 0.0;
  double c_ = 0.0;
};

} // namespace hdmbench
