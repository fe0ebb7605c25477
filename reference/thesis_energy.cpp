#include "reference/thesis_energy.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

double square(double value) {
  return value * value;
}

/// (4.7) for one component: both residuals of s - t - u.
double potential(double ms, double mt, double mu, double ds, double dt, double du) {
  return square(mt / mu * (dt - ds) - (du - dt)) + square(mt / ms * (dt - du) - (ds - dt));
}

} // namespace

std::size_t neighbour_along(Extent extent, std::size_t site, const std::array<int, 3>& line, int side) {
  const auto width = static_cast<std::size_t>(extent.width);
  const auto height = static_cast<std::size_t>(extent.height);
  const int x = static_cast<int>(site % width) + side * line[0];
  const int y = static_cast<int>(site / width % height) + side * line[1];
  const int z = static_cast<int>(site / (width * height)) + side * line[2];
  const bool inside = x >= 0 && x < extent.width && y >= 0 && y < extent.height && z >= 0 && z < extent.depth;
  return inside ? extent.index(x, y, z) : site;
}

template <typename Field>
auto ThesisEnergyOf<Field>::at(int x, int y, Value centre, int z) const -> Value {
  const Extent extent = level_.extent;
  const auto site = extent.index(x, y, z);
  const auto modulus = [&](std::size_t of) { return static_cast<double>(level_.modulus.values[of]); };
  const std::array<double, 3> dt{centre.x, centre.y, centre.z};
  std::array<double, 3> sums{};
  for (const auto& line : thesis_lines) {
    if (line[2] != 0 && extent.axes() == 2) {
      continue;
    }
    // Outside is the value that the centre had when the sweep began, not the candidate.
    const std::size_t s = neighbour_along(extent, site, line, -1);
    const std::size_t u = neighbour_along(extent, site, line, 1);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      const auto d = [&](std::size_t of) { return static_cast<double>(displacement_[axis][of]); };
      sums[axis] +=
          line[axis] != 0 ? potential(modulus(s), modulus(site), modulus(u), d(s), dt[axis], d(u)) : 0.0;
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

ReferenceField thesis_prolongation(const ReferenceField& coarse, Extent fine) {
  ReferenceField result(fine);
  for (std::size_t site = 0; site < fine.sites(); ++site) {
    std::array<std::array<int, 2>, 3> around{}; // the sites before and after, by axis
    std::array<double, 3> weight{};             // of the one after
    std::size_t rest = site;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto to = static_cast<std::size_t>(fine.sides()[axis]);
      const int last = coarse.extent.sides()[axis] - 1;
      const double position =
          to > 1 ? static_cast<double>(rest % to) * last / static_cast<double>(to - 1) : 0.0;
      const int before = static_cast<int>(position);
      around[axis] = {before, std::min(before + 1, last)};
      weight[axis] = position - before;
      rest /= to;
    }
    for (std::size_t component = 0; component < fine.axes(); ++component) {
      std::array<double, 8> corners{};
      for (std::size_t i = 0; i < corners.size(); ++i) {
        corners[i] = coarse[component]
                           [coarse.extent.index(around[0][i & 1], around[1][i >> 1 & 1], around[2][i >> 2])];
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < 4U >> axis; ++i) {
          corners[i] = std::lerp(corners[2 * i], corners[2 * i + 1], weight[axis]);
        }
      }
      result[component][site] = corners[0];
    }
  }
  return result;
}

} // namespace hdmbench
