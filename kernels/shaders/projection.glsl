// projection.inc for a site from its entries of the table (backends/session/level_arrays.hpp). The includer supplies
// displacement_at(i), a Vector of the coarse level.

#define HDM_VALUE Vector
#include "projection.inc"

Vector projected_in_slice(int slice, ivec2 coarse, vec4 column, vec4 row) {
  int first_row = (slice * coarse.y + int(row.x)) * coarse.x;
  int second_row = (slice * coarse.y + int(row.y)) * coarse.x;
  Vector north_west = displacement_at(first_row + int(column.x));
  Vector north_east = displacement_at(first_row + int(column.y));
  Vector south_west = displacement_at(second_row + int(column.x));
  Vector south_east = displacement_at(second_row + int(column.y));
  return projected(north_west, north_east, south_west, south_east, column.z, row.z);
}

Vector projected_displacement(ivec2 coarse, vec4 column, vec4 row, vec4 slice) {
#if HDM_AXES > 2
  return interpolated(projected_in_slice(int(slice.x), coarse, column, row),
                      projected_in_slice(int(slice.y), coarse, column, row), slice.z);
#else
  return projected_in_slice(0, coarse, column, row);
#endif
}
