#include "reference/circular_inclusion.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hdmbench {

namespace {

double kappa_of(double poisson) {
  return (3.0 - poisson) / (1.0 + poisson);
}

} // namespace

CircularInclusion::CircularInclusion(const Parameters& parameters) : parameters_(parameters) {
  if (!(parameters.radius > 0.0) || !(parameters.modulus_inside >= 0.0) ||
      !(parameters.modulus_outside > 0.0) || !(parameters.poisson > -1.0 && parameters.poisson <= 0.5)) {
    throw InputError(fmt::format(
        "a round inclusion of radius {}, moduli {} inside and {} outside and Poisson "
        "ratio {} cannot be",
        parameters.radius, parameters.modulus_inside, parameters.modulus_outside, parameters.poisson));
  }
  // Traction on the circle, phi + z conj(phi') + conj(psi), gives 1 - B = D, A - 2 = -2 F and C = -A / 2;
  // displacement, with g the ratio of the shear moduli, g (kappa - 1 + 2 B) = (kappa - 1) D and
  // g (kappa A + 2) = 2 F.
  const double kappa = kappa_of(parameters.poisson);
  const double g = parameters.modulus_inside / parameters.modulus_outside;
  a_ = 2.0 * (1.0 - g) / (1.0 + g * kappa);
  b_ = (kappa - 1.0) * (1.0 - g) / (2.0 * g + kappa - 1.0);
  c_ = -a_ / 2.0;
  d_ = 1.0 - b_;
  f_ = 1.0 - a_ / 2.0;
}

CircularInclusion::Potentials CircularInclusion::potentials(std::complex<double> z) const {
  const double load = parameters_.stretch * parameters_.modulus_outside; // S
  if (is_inside(z)) {
    return {.phi = load / 4.0 * d_ * z,
            .phi_slope = load / 4.0 * d_,
            .phi_curvature = 0.0,
            .psi = -load / 2.0 * f_ * z,
            .psi_slope = -load / 2.0 * f_};
  }
  const double square = parameters_.radius * parameters_.radius;
  const std::complex<double> near = square / z;        // a^2 / z
  const std::complex<double> nearer = near * near / z; // a^4 / z^3
  return {.phi = load / 4.0 * (z + a_ * near),
          .phi_slope = load / 4.0 * (1.0 - a_ * near / z),
          .phi_curvature = load / 2.0 * a_ * near / (z * z),
          .psi = -load / 2.0 * (z + b_ * near + c_ * nearer),
          .psi_slope = -load / 2.0 * (1.0 - b_ * near / z - 3.0 * c_ * nearer / z)};
}

std::complex<double> CircularInclusion::displacement(std::complex<double> z) const {
  const Potentials at = potentials(z);
  const double modulus = is_inside(z) ? parameters_.modulus_inside : parameters_.modulus_outside;
  const double twice_shear = modulus / (1.0 + parameters_.poisson); // 2 mu
  return (kappa_of(parameters_.poisson) * at.phi - z * std::conj(at.phi_slope) - std::conj(at.psi)) /
         twice_shear;
}

CircularInclusion::Stress CircularInclusion::stress(std::complex<double> z) const {
  const Potentials at = potentials(z);
  const double sum = 4.0 * at.phi_slope.real(); // xx + yy
  const std::complex<double> rest =
      2.0 * (std::conj(z) * at.phi_curvature + at.psi_slope); // yy - xx + 2 i xy
  return {(sum - rest.real()) / 2.0, (sum + rest.real()) / 2.0, rest.imag() / 2.0};
}

ElasticProblem CircularInclusion::on_pixels(int side) const {
  const Extent extent{side, side};
  ElasticProblem problem{.extent = extent,
                         .modulus = std::vector<double>(extent.sites()),
                         .fixed_x = std::vector<std::uint8_t>(extent.sites()),
                         .fixed_y = {},
                         .prescribed = ReferenceField(extent),
                         .force = {}};
  const double middle = (side - 1) / 2.0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const std::size_t at = extent.index(x, y);
      const std::complex<double> z(x - middle, y - middle);
      const std::complex<double> moved = displacement(z);
      problem.modulus[at] = is_inside(z) ? parameters_.modulus_inside : parameters_.modulus_outside;
      problem.prescribed[0][at] = moved.real();
      problem.prescribed[1][at] = moved.imag();
      problem.fixed_x[at] = x == 0 || y == 0 || x + 1 == side || y + 1 == side ? 1 : 0;
    }
  }
  problem.fixed_y = problem.fixed_x;
  return problem;
}

} // namespace hdmbench
