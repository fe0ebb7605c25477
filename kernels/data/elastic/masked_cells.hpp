#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace hdmbench {

/// Force on each component of a cell's corners by each of them, with the opposite sign: row by row, 8 x 8
/// in an image (x and y of four corners in reading order) or 24 x 24 in a volume. In double, on the way to a
/// coarser level.
struct CellMatrix {
  /// All 0; 2 or 3 axes.
  explicit CellMatrix(std::size_t axes_) : axes(axes_), components(axes << axes) {
    std::fill_n(values.begin(), components * components, 0.0);
  }

  [[nodiscard]] double& at(std::size_t row, std::size_t column) { return values[row * components + column]; }
  [[nodiscard]] double at(std::size_t row, std::size_t column) const {
    return values[row * components + column];
  }

  std::size_t axes;
  std::size_t components;
  std::array<double, 576> values; ///< what lies beyond components * components is not set
};

/// Which of a cell's components a coarse function may move: 0 or 1.
using CellMask = std::array<double, 24>;

/// sum += P' child P, P being the linear interpolation from the corners of a parent to those of its child,
/// the one at 0 or 1 of each axis, x in the lowest bit of `place`, with rows of components that `mask` has as
/// 0 left out. Along axes whose bits `halved` has not, the child is as long as the parent.
void add_galerkin(CellMatrix& sum, const CellMatrix& child, std::size_t place, const CellMask& mask,
                  unsigned halved = 7);

/// The cells of a level whose basis functions are cut by conditions, in reading order: each has a matrix in
/// place of moments.
struct MaskedCells {
  std::vector<int> x;             ///< of each
  std::vector<float> stiffness;   ///< CellMatrix of each, column by column (it is symmetric)
  std::size_t components = 8;     ///< of a cell: 8 or 24
  std::size_t rows = 0;           ///< of cells in a plane
  std::vector<std::size_t> begin; ///< of each row of cells, and the end

  [[nodiscard]] bool empty() const { return x.empty(); }
  [[nodiscard]] const float* matrix(std::size_t cell) const {
    return stiffness.data() + cell * components * components;
  }
  /// Those of row (y, z): indices first and last. Rows that are not there have none.
  [[nodiscard]] std::array<std::size_t, 2> row(int y, int z = 0) const {
    const auto number = static_cast<std::size_t>(z) * rows + static_cast<std::size_t>(y);
    if (y < 0 || z < 0 || static_cast<std::size_t>(y) >= rows || number + 1 >= begin.size()) {
      return {0, 0};
    }
    return {begin[number], begin[number + 1]};
  }
};

} // namespace hdmbench
