// What sample.comp and project.comp are told; backends/session/device_session.cpp has the same for C++.

#include "fields.glsl"

PARAMETERS(8)
#define width parameters[0] // of the level
#define from_width parameters[3]
// and where the level's entries begin: parameters[6] those of columns, parameters[7] those of rows

vec4 column_entry(int column) { return texelFetch(entries, parameters[6] + column); }
vec4 row_entry(int row) { return texelFetch(entries, parameters[7] + row); }
