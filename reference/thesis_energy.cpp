#include "reference/thesis_energy.hpp"

#include <cmath>

namespace hdmbench {

namespace {

struct Sample {
  double dx = 0.0;
  double dy = 0.0;
  double m = 0.0;
};

double square(double value) {
  return value * value;
}

/// (4.7) for one component: both residuals of s - t - u.
double potential(double ms, double mt, double mu, double ds, double dt, double du) {
  return square(mt / mu * (dt - ds) - (du - dt)) + square(mt / ms * (dt - du) - (ds - dt));
}

} // namespace

template <typename Field>
auto ThesisEnergyOf<Field>::at(int x, int y, Value centre) const -> Value {
  const Extent extent = level_.extent;
  const auto site = extent.index(x, y);
  const double mt = static_cast<double>(level_.modulus.values[site]);
  const auto sample = [&](int dx, int dy) {
    const int nx = x + dx;
    const int ny = y + dy;
    if (nx < 0 || nx >= extent.width || ny < 0 || ny >= extent.height) {
      // The value the centre had when the sweep began, not the candidate.
      return Sample{displacement_[0][site], displacement_[1][site], mt};
    }
    const auto at = extent.index(nx, ny);
    return Sample{displacement_[0][at], displacement_[1][at], static_cast<double>(level_.modulus.values[at])};
  };
  const auto triple = [&](int dx, int dy) {
    const Sample s = sample(-dx, -dy);
    const Sample u = sample(dx, dy);
    return Value{potential(s.m, mt, u.m, s.dx, centre.x, u.dx),
                 potential(s.m, mt, u.m, s.dy, centre.y, u.dy)};
  };
  const Value falling = triple(1, 1);
  const Value rising = triple(1, -1);
  const double penalty = static_cast<double>(level_.penalty);
  const double observation_x = penalty * static_cast<double>(level_.confidence[0][site]) *
                               std::abs(static_cast<double>(level_.target[0][site]) - centre.x);
  const double observation_y = penalty * static_cast<double>(level_.confidence[1][site]) *
                               std::abs(static_cast<double>(level_.target[1][site]) - centre.y);
  return {triple(1, 0).x + falling.x + rising.x + observation_x,
          triple(0, 1).y + falling.y + rising.y + observation_y};
}

template <typename Field>
auto ThesisEnergyOf<Field>::at(int x, int y) const -> Value {
  const auto site = level_.extent.index(x, y);
  return at(x, y, {displacement_[0][site], displacement_[1][site]});
}

template class ThesisEnergyOf<VectorField>;
template class ThesisEnergyOf<ReferenceField>;

} // namespace hdmbench
