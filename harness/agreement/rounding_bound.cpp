#include "harness/agreement/rounding_bound.hpp"

#include "kernels/energy_macros.hpp"
#include "kernels/gather.hpp"

#include <cmath>

namespace hdmbench {

namespace {

namespace bounded {

/// Unit roundoff of float32, and the spacing of its subnormal numbers halved: what an underflow may lose.
constexpr double unit_roundoff = 0x1p-24;
constexpr double underflow = 0x1p-150;
/// The bounds are themselves computed in double; this covers their rounding.
constexpr double inflation = 1.0 + 0x1p-40;

/// A float result and how far it may be from the exact one.
struct real {
  float value = 0.0F;
  double error = 0.0;

  real() = default;
  // Implicit, as energy.inc writes constants.
  real(int constant) : value(static_cast<float>(constant)) {}
  real(float value_, double error_ = 0.0) : value(value_), error(error_) {}

  static real rounded(float result, double inherited) {
    return {result,
            inflation * (inherited + unit_roundoff * std::abs(static_cast<double>(result)) + underflow)};
  }
  friend real operator+(real a, real b) { return rounded(a.value + b.value, a.error + b.error); }
  friend real operator-(real a, real b) { return rounded(a.value - b.value, a.error + b.error); }
  friend real operator*(real a, real b) {
    const double inherited = std::abs(static_cast<double>(a.value)) * b.error +
                             std::abs(static_cast<double>(b.value)) * a.error + a.error * b.error;
    return rounded(a.value * b.value, inherited);
  }
  friend bool operator<(real a, real b) { return a.value < b.value; }
};

HDM_FUNCTION real abs(real a) {
  return {std::abs(a.value), a.error};
}

#include "kernels/energy.inc"

Neighbours exact(const energy::Neighbours& from) {
  return {from.north_west, from.north,      from.north_east, from.west,      from.centre,
          from.east,       from.south_west, from.south,      from.south_east};
}

/// 1 / m as the host rounded it. Its relative error of at most unit roundoff is taken by the quotient's
/// result.
real rounded_inverse(float inverse) {
  return {inverse, unit_roundoff * static_cast<double>(inverse) * (1.0 + 2.0 * unit_roundoff)};
}

Neighbours rounded_inverses(const energy::Neighbours& from) {
  return {rounded_inverse(from.north_west), rounded_inverse(from.north),  rounded_inverse(from.north_east),
          rounded_inverse(from.west),       rounded_inverse(from.centre), rounded_inverse(from.east),
          rounded_inverse(from.south_west), rounded_inverse(from.south),  rounded_inverse(from.south_east)};
}

} // namespace bounded

} // namespace

EnergyBound energy_change_bound(const Level& level, const VectorField& displacement, int x, int y,
                                float step_x, float step_y) {
  const energy::Site from = energy::gather(level, displacement, x, y);
  const bounded::Site site{bounded::exact(from.dx),
                           bounded::exact(from.dy),
                           bounded::rounded_inverses(from.inverse_modulus),
                           from.modulus,
                           from.target_x,
                           from.target_y,
                           from.confidence_x,
                           from.confidence_y,
                           from.penalty,
                           0, // of no use to a step
                           0};
  const bounded::Parabolas prior = bounded::prior_parabolas(site);
  return {bounded::energy_change(step_x, prior.gradient_x, prior.curvature_x, site.target_x - site.dx.centre,
                                 site.penalty * site.confidence_x)
              .error,
          bounded::energy_change(step_y, prior.gradient_y, prior.curvature_y, site.target_y - site.dy.centre,
                                 site.penalty * site.confidence_y)
              .error};
}

} // namespace hdmbench
