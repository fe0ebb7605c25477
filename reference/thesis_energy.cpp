#include "reference/thesis_energy.hpp"

#include <array>
#include <cmath>

namespace hdmbench {

namespace {

struct Sample {
  std::array<double, 3> d{};
  double m = 0.0;
};

/// Half of the neighbours; the lines through these and their opposites are all. A component sees those that
/// leave along its axis. An image has the lines that do not leave along z.
constexpr std::array<std::array<int, 3>, 13> lines{{{1, 0, 0},
                                                    {0, 1, 0},
                                                    {0, 0, 1},
                                                    {1, 1, 0},
                                                    {1, -1, 0},
                                                    {1, 0, 1},
                                                    {1, 0, -1},
                                                    {0, 1, 1},
                                                    {0, 1, -1},
                                                    {1, 1, 1},
                                                    {1, 1, -1},
                                                    {1, -1, 1},
                                                    {1, -1, -1}}};

double square(double value) {
  return value * value;
}

/// (4.7) for one component: both residuals of s - t - u.
double potential(double ms, double mt, double mu, double ds, double dt, double du) {
  return square(mt / mu * (dt - ds) - (du - dt)) + square(mt / ms * (dt - du) - (ds - dt));
}

} // namespace

template <typename Field>
auto ThesisEnergyOf<Field>::at(int x, int y, Value centre, int z) const -> Value {
  const Extent extent = level_.extent;
  const auto site = extent.index(x, y, z);
  const auto sample = [&](std::array<int, 3> line, int side) {
    const int nx = x + side * line[0];
    const int ny = y + side * line[1];
    const int nz = z + side * line[2];
    const bool inside =
        nx >= 0 && nx < extent.width && ny >= 0 && ny < extent.height && nz >= 0 && nz < extent.depth;
    // Outside is the value that the centre had when the sweep began, not the candidate.
    const auto at = inside ? extent.index(nx, ny, nz) : site;
    Sample found{.m = static_cast<double>(level_.modulus.values[at])};
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      found.d[axis] = displacement_[axis][at];
    }
    return found;
  };
  const double mt = static_cast<double>(level_.modulus.values[site]);
  const std::array<double, 3> dt{centre.x, centre.y, centre.z};
  std::array<double, 3> sums{};
  for (const auto& line : lines) {
    if (line[2] != 0 && extent.axes() == 2) {
      continue;
    }
    const Sample s = sample(line, -1);
    const Sample u = sample(line, 1);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      sums[axis] += line[axis] != 0 ? potential(s.m, mt, u.m, s.d[axis], dt[axis], u.d[axis]) : 0.0;
    }
  }
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    sums[axis] += static_cast<double>(level_.penalty) * static_cast<double>(level_.confidence[axis][site]) *
                  std::abs(static_cast<double>(level_.target[axis][site]) - dt[axis]);
  }
  return {sums[0], sums[1], sums[2]};
}

template <typename Field>
auto ThesisEnergyOf<Field>::at(int x, int y, int z) const -> Value {
  const Extent extent = level_.extent;
  const auto site = extent.index(x, y, z);
  return at(
      x, y,
      {displacement_[0][site], displacement_[1][site], extent.axes() > 2 ? displacement_[2][site] : 0.0}, z);
}

template class ThesisEnergyOf<VectorField>;
template class ThesisEnergyOf<ReferenceField>;

} // namespace hdmbench
