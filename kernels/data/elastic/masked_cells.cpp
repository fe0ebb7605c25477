#include "kernels/data/elastic/masked_cells.hpp"

namespace hdmbench {

namespace {

/// The share of a parent's corner in the site at 0, 1 or 2 half cells from its first corner.
constexpr std::array<std::array<double, 2>, 3> shares{{{1.0, 0.0}, {0.5, 0.5}, {0.0, 1.0}}};

} // namespace

void add_galerkin(CellMatrix& sum, const CellMatrix& child, std::size_t place, const CellMask& mask) {
  const std::size_t axes = sum.axes;
  const std::size_t corners = std::size_t{1} << axes;
  std::array<std::array<double, 8>, 24> share{}; // of each parent's corner in each of the child's components
  for (std::size_t at = 0; at < sum.components; ++at) {
    for (std::size_t corner = 0; corner < corners; ++corner) {
      share[at][corner] = mask[at];
      for (std::size_t axis = 0; axis < axes; ++axis) {
        const auto bit = [&](std::size_t of) { return of >> axis & 1; };
        share[at][corner] *= shares[bit(place) + bit(at / axes)][bit(corner)];
      }
    }
  }
  for (std::size_t at = 0; at < sum.components; ++at) {
    std::array<std::array<double, 8>, 3> part{}; // a row of child * P: of each axis the corners
    for (std::size_t other = 0; other < sum.components; ++other) {
      const double stiffness = child.at(at, other);
      for (std::size_t corner = 0; corner < corners; ++corner) {
        part[other % axes][corner] += stiffness * share[other][corner];
      }
    }
    for (std::size_t corner = 0; corner < corners; ++corner) {
      const double weight = share[at][corner];
      if (weight == 0.0) {
        continue;
      }
      for (std::size_t other = 0; other < sum.components; ++other) {
        sum.at(axes * corner + at % axes, other) += weight * part[other % axes][other / axes];
      }
    }
  }
}

} // namespace hdmbench
