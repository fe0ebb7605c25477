#pragma once

#include <cstdint>

/// One row of a sweep, compiled once per instruction set (row.cpp). Plain pointers only: a template of the
/// standard library instantiated there could be picked by the linker for code that runs on any processor.
namespace hdmbench::openmp {

/// For site number i of a row, pointer[i] is the value of that neighbour. Where a neighbour is outside the
/// image its pointer is `centre`: the border rule costs nothing in the loop.
struct NeighbourPointers {
  const float* north_west;
  const float* north;
  const float* north_east;
  const float* west;
  const float* centre;
  const float* east;
  const float* south_west;
  const float* south;
  const float* south_east;
};

/// Sites first ... last - 1 of one row or of its columns of one parity (layout.hpp), all with the same kind
/// of neighbours, all with an observation or all without. Their turn is the same: that of all x, all y, or
/// both.
struct RowPart {
  NeighbourPointers dx;
  NeighbourPointers dy;
  NeighbourPointers inverse_modulus;
  const float* modulus;
  const float* target_x;
  const float* target_y;
  const float* confidence_x;
  const float* confidence_y;
  const float* inverse_curvature_x; ///< null where the rule does not need it
  const float* inverse_curvature_y;
  float penalty;
  const float* steps; ///< 16 values
  int step_count;     ///< 1 ... 16
  float strength = 0; ///< this and the next two: update.inc's Sweep
  float number = 0;
  float seed = 0;
  int row;
  int column; ///< of site 0
  int stride; ///< columns from one site to the next
  /// Written where it is the component's turn. May be dx.centre, dy.centre if what moves does not see what
  /// moves; must not overlap anything else above.
  float* next_x;
  float* next_y;
  int first;
  int last;
  int rule; ///< update.inc's number
  bool moves_x = true;
  bool moves_y = true;
  bool observed; ///< false: both confidences are 0 all along the part; they are not read
};

/// Returns the number of sites that changed.
using SweepRow = std::int64_t (*)(const RowPart& part);

namespace baseline {
std::int64_t sweep_row(const RowPart& part);
}
namespace avx2 {
std::int64_t sweep_row(const RowPart& part);
}
namespace avx512 {
std::int64_t sweep_row(const RowPart& part);
}

} // namespace hdmbench::openmp
