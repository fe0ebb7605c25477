#include "reference/round_inclusion.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hdmbench {

RoundInclusion::RoundInclusion(const Parameters& parameters) : parameters_(parameters) {
  const auto d = static_cast<double>(parameters.axes);
  const double nu = parameters.poisson;
  if (!(parameters.radius > 0.0) || !(parameters.modulus_inside >= 0.0) ||
      !(parameters.modulus_outside > 0.0) || !(nu > -1.0 && (d - 1.0) * nu < 1.0 && nu <= 0.5)) {
    throw InputError(
        fmt::format("a round inclusion of radius {}, moduli {} inside and {} outside and Poisson "
                    "ratio {} cannot be",
                    parameters.radius, parameters.modulus_inside, parameters.modulus_outside, nu));
  }
  const double g = parameters.modulus_inside / parameters.modulus_outside;
  const double lame = 2.0 * nu / (1.0 - (d - 1.0) * nu); // of a sheet: plane stress
  const double k = d * lame + 2.0;
  p_ = 2.0 / (lame + 1.0);
  m_ = p_ + 2.0 * d / (d + 2.0);
  b_ = k * (1.0 - g) / (g * k + 2.0 * (d - 1.0));
  c_ = (1.0 - g) / (p_ * (d - 2.0) / 2.0 + d * d / (d + 2.0) + g * m_);
}

double RoundInclusion::square_distance(const Point& at) const {
  double sum = 0.0;
  for (std::size_t axis = 0; axis < parameters_.axes; ++axis) {
    sum += at[axis] * at[axis];
  }
  return sum / (parameters_.radius * parameters_.radius);
}

double RoundInclusion::modulus(const Point& at) const {
  return square_distance(at) < 1.0 ? parameters_.modulus_inside : parameters_.modulus_outside;
}

Point RoundInclusion::displacement(const Point& at) const {
  const auto d = static_cast<double>(parameters_.axes);
  const double mean = parameters_.stretch * (1.0 - (d - 1.0) * parameters_.poisson) / d;
  Point deviation{}; // D x
  double q = 0.0;    // with lengths in radii, as below
  for (std::size_t axis = 0; axis < parameters_.axes; ++axis) {
    deviation[axis] = ((axis == 0 ? 1.0 : -parameters_.poisson) * parameters_.stretch - mean) * at[axis];
    q += at[axis] * deviation[axis] / (parameters_.radius * parameters_.radius);
  }
  const double square = square_distance(at);
  double along_place = mean * (1.0 + b_); // the factors of x and of D x
  double along_deviation = 1.0 + c_ * m_;
  if (square >= 1.0) {
    const double far = std::pow(square, -d / 2.0);
    along_place = mean * (1.0 + b_ * far) + c_ * d * far * q / square * (1.0 - 1.0 / square);
    along_deviation = 1.0 + c_ * far * (p_ + 2.0 * d / (d + 2.0) / square);
  }
  Point result{};
  for (std::size_t axis = 0; axis < parameters_.axes; ++axis) {
    result[axis] = along_place * at[axis] + along_deviation * deviation[axis];
  }
  return result;
}

ElasticProblem RoundInclusion::on_sites(int side) const {
  const Extent extent{side, side, parameters_.axes == 2 ? 1 : side};
  const auto from_centre = [&](Point at) {
    for (std::size_t axis = 0; axis < parameters_.axes; ++axis) {
      at[axis] -= (side - 1) / 2.0;
    }
    return at;
  };
  return clamped_body(
      extent, [&](const Point& at) { return modulus(from_centre(at)); },
      [&](const Point& at) { return displacement(from_centre(at)); });
}

} // namespace hdmbench
