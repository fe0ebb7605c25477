#pragma once

#include "kernels/data/pyramid.hpp"

#include <span>
#include <vector>

namespace hdmbench {

/// Means of the moduli of the full image over what each site of a level stands for (Material::mean), summed
/// up row by row in rising order, so that processes that have some rows each can hand the sums on.
class MeanModulus {
public:
  MeanModulus(Extent full, Extent level, Alignment alignment);

  /// Indices first ... last of an axis, both included.
  struct Range {
    int first = 0;
    int last = 0;
  };
  /// Rows of the full image that a row of the level stands for. Both ends rise from row to row; two rows may
  /// have one in common.
  [[nodiscard]] Range rows(int level_row) const { return rows_[static_cast<std::size_t>(level_row)]; }

  /// Adds what a row of the full image has to the sums of a row of the level, a sum per column.
  void add(std::span<const float> moduli, std::span<double> sums) const;
  /// The means of a row of the level whose sums are complete.
  void divide(int level_row, std::span<const double> sums, std::span<float> means) const;

private:
  std::vector<Range> columns_; ///< per column of the level
  std::vector<Range> rows_;
};

} // namespace hdmbench
