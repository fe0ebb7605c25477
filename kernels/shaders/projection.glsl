// projection.inc for both components of a site, from its entries of the table (backends/session/level_arrays.hpp).
// The includer supplies displacement_at(i), a vec2 of the coarse level.

#include "projection.inc"

vec2 projected_displacement(int coarse_width, vec4 column, vec4 row) {
  int first_row = int(row.x) * coarse_width;
  int second_row = int(row.y) * coarse_width;
  vec2 north_west = displacement_at(first_row + int(column.x));
  vec2 north_east = displacement_at(first_row + int(column.y));
  vec2 south_west = displacement_at(second_row + int(column.x));
  vec2 south_east = displacement_at(second_row + int(column.y));
  return vec2(projected(north_west.x, north_east.x, south_west.x, south_east.x, column.z, row.z),
              projected(north_west.y, north_east.y, south_west.y, south_east.y, column.z, row.z));
}
