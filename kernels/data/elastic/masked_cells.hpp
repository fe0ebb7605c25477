#pragma once

#include "kernels/specification/elastic/elastic.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace hdmbench {

/// Force on each of a cell's eight components, x and y of the corners in reading order, by each of them, with
/// the opposite sign: row by row. In double, on the way to a coarser level.
using CellMatrix = std::array<double, 64>;

/// Of a cell that its moments describe.
[[nodiscard]] CellMatrix cell_matrix(const ElasticInFloat::CellMoments& moments,
                                     const ElasticInFloat::PoissonRatio& ratio);

/// Which of a cell's eight components a coarse function may move: 0 or 1.
using CellMask = std::array<double, 8>;

/// sum += P' child P, P being the bilinear interpolation from the corners of a parent to those of its child
/// at column and row 0 or 1, with rows of components that `mask` has as 0 left out.
void add_galerkin(CellMatrix& sum, const CellMatrix& child, int column, int row, const CellMask& mask);

/// A coarse cell whose basis functions are cut by conditions.
struct MaskedCell {
  int x = 0;
  /// CellMatrix in float, column by column (it is symmetric): eight forces advance side by side.
  std::array<float, 64> stiffness{};
};

/// Those of a level in reading order.
struct MaskedCells {
  std::vector<MaskedCell> cells;
  std::vector<std::size_t> row_begin; ///< of each row of cells, and the end

  /// Those of row y: indices first and last.
  [[nodiscard]] std::array<std::size_t, 2> row(int y) const {
    if (y < 0 || static_cast<std::size_t>(y) + 1 >= row_begin.size()) {
      return {0, 0};
    }
    return {row_begin[static_cast<std::size_t>(y)], row_begin[static_cast<std::size_t>(y) + 1]};
  }
};

} // namespace hdmbench
