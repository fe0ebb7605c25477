#pragma once

#include "backends/openmp/row.hpp"
#include "kernels/field.hpp"

#include <vector>

namespace hdmbench::openmp {

/// Where the values of an image lie in memory. With stride 1 as everywhere. With stride 2 a row's even
/// columns come before its odd ones: the sites of one colour are neighbours in memory, their neighbours too,
/// and a coloured sweep reads and computes nothing for those whose turn it is not. The columns of one parity
/// are a phase.
struct Layout {
  Extent extent;
  int stride = 1; ///< 1 or 2, the number of phases

  /// Index of the first value of a phase of row y.
  [[nodiscard]] std::size_t start(int y, int phase) const {
    return extent.index(phase == 0 ? 0 : (extent.width + 1) / 2, y);
  }
  /// How many sites of a row are of the phase.
  [[nodiscard]] int count(int phase) const { return (extent.width - phase + stride - 1) / stride; }
  /// The column of site i of a phase.
  [[nodiscard]] int column(int i, int phase) const { return i * stride + phase; }

  /// `values`, one per site in reading order, into this layout; resizes `to`.
  void arrange(const std::vector<float>& values, std::vector<float>& to, int threads) const;
  /// Back again; `to` has the size of `values`.
  void restore(const std::vector<float>& values, std::vector<float>& to, int threads) const;

  /// Pointers into `values` for sites first ... last - 1 of a phase of row y, indexed by site. A column at
  /// the border must be a part by itself.
  [[nodiscard]] NeighbourPointers neighbours(const std::vector<float>& values, int y, int phase, int first,
                                             int last) const;
};

} // namespace hdmbench::openmp
