#pragma once

#include "kernels/data/elastic/hierarchy.hpp"

#include <algorithm>
#include <array>

namespace hdmbench {

/// The moments of a row of cells, for loops of vectors: pointers that no store can change. `Value` is float
/// or const float; cell x lies at the bottom right of site x.
template <typename Value>
struct MomentsRow {
  std::array<Value*, 6> moments{};

  /// Of an ElasticLevel, row y >= -1.
  template <typename OfLevel>
  MomentsRow(OfLevel& level, int y) {
    std::ranges::transform(level.moments, moments.begin(),
                           [&](auto& values) { return values.data() + level.grid.index(0, y); });
  }

  [[nodiscard]] ElasticInFloat::CellMoments cell(int x) const {
    return {moments[0][x], moments[1][x], moments[2][x], moments[3][x], moments[4][x], moments[5][x]};
  }
  void set(int x, const ElasticInFloat::CellMoments& cell) const {
    moments[0][x] = cell.m;
    moments[1][x] = cell.mr;
    moments[2][x] = cell.ms;
    moments[3][x] = cell.mrr;
    moments[4][x] = cell.mss;
    moments[5][x] = cell.mrs;
  }
};

} // namespace hdmbench
