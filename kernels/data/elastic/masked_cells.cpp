#include "kernels/data/elastic/masked_cells.hpp"

namespace hdmbench {

namespace {

/// The share of a parent's corner in the site at 0, 1 or 2 half cells from its first corner.
constexpr std::array<std::array<double, 2>, 3> shares{{{1.0, 0.0}, {0.5, 0.5}, {0.0, 1.0}}};

constexpr CellMatrix identity = [] {
  CellMatrix result{};
  for (std::size_t i = 0; i < 8; ++i) {
    result[9 * i] = 1.0;
  }
  return result;
}();

using InDouble = Elastic<double>;

/// One component of the corners where the component `column` of all is 1 and the others are 0.
HDM_FUNCTION InDouble::CellCorners unit_corners(std::size_t component, std::size_t column) {
  const double* const unit = identity.data() + 8 * component + column;
  return {unit[0], unit[16], unit[32], unit[48]};
}

HDM_FUNCTION void set_forces(CellMatrix& matrix, std::size_t corner, std::size_t column,
                             InDouble::Force force) {
  matrix[16 * corner + column] = -force.x;
  matrix[16 * corner + 8 + column] = -force.y;
}

/// A function of its own: locals declared inside an `omp simd` loop would become arrays in memory.
HDM_FUNCTION void set_column(CellMatrix& matrix, const InDouble::CellMoments& moments,
                             const InDouble::PoissonRatio& ratio, std::size_t column) {
  const InDouble::CellTension tension =
      InDouble::cell_tension(moments, unit_corners(0, column), unit_corners(1, column), ratio);
  set_forces(matrix, 0, column, InDouble::force_on_top_left(tension));
  set_forces(matrix, 1, column, InDouble::force_on_top_right(tension));
  set_forces(matrix, 2, column, InDouble::force_on_bottom_left(tension));
  set_forces(matrix, 3, column, InDouble::force_on_bottom_right(tension));
}

} // namespace

CellMatrix cell_matrix(const ElasticInFloat::CellMoments& moments,
                       const ElasticInFloat::PoissonRatio& ratio) {
  const InDouble::CellMoments wide{moments.m, moments.mr, moments.ms, moments.mrr, moments.mss, moments.mrs};
  const InDouble::PoissonRatio wide_ratio{ratio.nu, ratio.shear};
  CellMatrix matrix{};
#pragma omp simd
  for (std::size_t column = 0; column < 8; ++column) {
    set_column(matrix, wide, wide_ratio, column);
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
  for (std::size_t at = 0; at < 8; ++at) {
    std::array<std::array<double, 4>, 2> half{}; // a row of child * P: x of the corners, then y
    for (std::size_t other = 0; other < 8; ++other) {
      const double stiffness = child[8 * at + other];
      for (std::size_t corner = 0; corner < 4; ++corner) {
        half[other % 2][corner] += stiffness * share[other][corner];
      }
    }
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const double weight = share[at][corner];
      if (weight == 0.0) {
        continue;
      }
      double* const to = sum.data() + 8 * (2 * corner + at % 2);
      for (std::size_t other = 0; other < 8; ++other) {
        to[other] += weight * half[other % 2][other / 2];
      }
    }
  }
}

} // namespace hdmbench
