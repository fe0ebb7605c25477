#include "kernels/data/elastic/masked_cells.hpp"

namespace hdmbench {

namespace {

/// The share of a parent's corner in the site at 0, 1 or 2 half cells from its first corner.
constexpr std::array<std::array<double, 2>, 3> shares{{{1.0, 0.0}, {0.5, 0.5}, {0.0, 1.0}}};

} // namespace

CellMatrix cell_matrix(const ElasticInFloat::CellMoments& moments,
                       const ElasticInFloat::PoissonRatio& ratio) {
  using InDouble = Elastic<double>;
  const InDouble::CellMoments wide{moments.m, moments.mr, moments.ms, moments.mrr, moments.mss, moments.mrs};
  const InDouble::PoissonRatio wide_ratio{ratio.nu, ratio.shear};
  CellMatrix matrix{};
  for (std::size_t column = 0; column < 8; ++column) {
    std::array<double, 8> unit{};
    unit[column] = 1.0;
    const auto tension = InDouble::cell_tension(wide, {unit[0], unit[2], unit[4], unit[6]},
                                                {unit[1], unit[3], unit[5], unit[7]}, wide_ratio);
    const std::array forces{InDouble::force_on_top_left(tension), InDouble::force_on_top_right(tension),
                            InDouble::force_on_bottom_left(tension),
                            InDouble::force_on_bottom_right(tension)};
    for (std::size_t corner = 0; corner < 4; ++corner) {
      matrix[8 * (2 * corner) + column] = -forces[corner].x;
      matrix[8 * (2 * corner + 1) + column] = -forces[corner].y;
    }
  }
  return matrix;
}

void add_galerkin(CellMatrix& sum, const CellMatrix& child, int column, int row, const CellMask& mask) {
  std::array<std::array<double, 4>, 8> share{}; // of each parent's corner in each of the child's components
  for (std::size_t at = 0; at < 8; ++at) {
    const auto& along_x = shares[static_cast<std::size_t>(column) + at / 2 % 2];
    const auto& along_y = shares[static_cast<std::size_t>(row) + at / 4];
    for (std::size_t corner = 0; corner < 4; ++corner) {
      share[at][corner] = mask[at] * along_x[corner % 2] * along_y[corner / 2];
    }
  }
  CellMatrix half{}; // child * P
  for (std::size_t at = 0; at < 8; ++at) {
    for (std::size_t other = 0; other < 8; ++other) {
      for (std::size_t corner = 0; corner < 4; ++corner) {
        half[8 * at + 2 * corner + other % 2] += child[8 * at + other] * share[other][corner];
      }
    }
  }
  for (std::size_t at = 0; at < 8; ++at) {
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const double weight = share[at][corner];
      if (weight != 0.0) {
        for (std::size_t other = 0; other < 8; ++other) {
          sum[8 * (2 * corner + at % 2) + other] += weight * half[8 * at + other];
        }
      }
    }
  }
}

} // namespace hdmbench
