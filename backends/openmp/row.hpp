#pragma once

#include <cstdint>

/// One row of a simultaneous sweep, compiled once per instruction set (row.cpp). Plain pointers only: a
/// template of the standard library instantiated there could be picked by the linker for code that runs on
/// any processor.
namespace hdmbench::openmp {

/// For the site in column x, pointer[x] is the value of that neighbour. Where a neighbour is outside the
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

/// Sites first ... last - 1 of one row, all with the same kind of neighbours, all with an observation or all
/// without.
struct RowPart {
  NeighbourPointers dx;
  NeighbourPointers dy;
  NeighbourPointers inverse_modulus;
  const float* modulus;
  const float* target_x;
  const float* target_y;
  const float* confidence_x;
  const float* confidence_y;
  float penalty;
  const float* steps; ///< 16 values
  int step_count;     ///< 1 ... 16
  float* next_x;      ///< must not overlap anything above
  float* next_y;
  int first;
  int last;
  bool observed; ///< false: both confidences are 0 all along the part; they and the targets are not read
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
