// What sample.comp and project.comp are told; backends/shared/resampling_entries.hpp has the same for C++.

#include "fields.glsl"

PARAMETERS(Resampling)
PARAMETER(0) int width; // of the level
PARAMETER(1) int from_width;
PARAMETER(2) int first_column; // of the level's entries
PARAMETER(3) int first_row;
PARAMETERS_END

vec4 column_entry(int column) { return texelFetch(entries, first_column + column); }
vec4 row_entry(int row) { return texelFetch(entries, first_row + row); }
