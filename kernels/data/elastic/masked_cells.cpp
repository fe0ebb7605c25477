#include "kernels/data/elastic/masked_cells.hpp"

namespace hdmbench {

namespace {

/// The share of a parent's corner in the site at 0, 1 or 2 half cells from its first corner.
constexpr std::array<std::array<double, 2>, 3> shares{{{1.0, 0.0}, {0.5, 0.5}, {0.0, 1.0}}};

template <std::size_t axes>
void add_child(CellMatrix& sum, const CellMatrix& child, std::size_t place, const CellMask& mask) {
  constexpr std::size_t corners = std::size_t{1} << axes;
  constexpr std::size_t components = axes * corners;
  // The corners of the parent that a component of the child hangs on, and its share of each.
  struct Shares {
    std::size_t count = 0;
    std::array<std::size_t, corners> corner;
    std::array<double, corners> share;
  };
  std::array<Shares, components> of;
  for (std::size_t at = 0; at < components; ++at) {
    for (std::size_t corner = 0; corner < corners; ++corner) {
      double share = mask[at];
      for (std::size_t axis = 0; axis < axes; ++axis) {
        const auto bit = [&](std::size_t number) { return number >> axis & 1; };
        share *= shares[bit(place) + bit(at / axes)][bit(corner)];
      }
      if (share != 0.0) {
        of[at].corner[of[at].count] = corner;
        of[at].share[of[at].count++] = share;
      }
    }
  }
  for (std::size_t at = 0; at < components; ++at) {
    if (of[at].count == 0) {
      continue;
    }
    std::array<double, components> row{}; // of child * P
    for (std::size_t other = 0; other < components; ++other) {
      const double stiffness = child.values[components * at + other];
      for (std::size_t i = 0; i < of[other].count; ++i) {
        row[axes * of[other].corner[i] + other % axes] += stiffness * of[other].share[i];
      }
    }
    for (std::size_t i = 0; i < of[at].count; ++i) {
      const double weight = of[at].share[i];
      double* const to = sum.values.data() + components * (axes * of[at].corner[i] + at % axes);
      for (std::size_t other = 0; other < components; ++other) {
        to[other] += weight * row[other];
      }
    }
  }
}

} // namespace

void add_galerkin(CellMatrix& sum, const CellMatrix& child, std::size_t place, const CellMask& mask) {
  sum.axes == 2 ? add_child<2>(sum, child, place, mask) : add_child<3>(sum, child, place, mask);
}

} // namespace hdmbench
