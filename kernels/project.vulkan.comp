#version 450
#extension GL_GOOGLE_include_directive : require

// The displacement a level begins with, from the level computed before it, an invocation per site.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise

layout(local_size_x = 64) in;

#include "resampling.vulkan.glsl"

#include "projection.inc"

void main() {
  ivec2 site = ivec2(gl_GlobalInvocationID.xy);
  if (site.x < width) {
    vec4 column = column_entry(site.x);
    vec4 row = row_entry(site.y);
    int first_row = int(row.x) * from_width;
    int second_row = int(row.y) * from_width;
    vec2 north_west = texelFetch(displacement, first_row + int(column.x)).xy;
    vec2 north_east = texelFetch(displacement, first_row + int(column.y)).xy;
    vec2 south_west = texelFetch(displacement, second_row + int(column.x)).xy;
    vec2 south_east = texelFetch(displacement, second_row + int(column.y)).xy;
    real x = projected(north_west.x, north_east.x, south_west.x, south_east.x, column.z, row.z);
    real y = projected(north_west.y, north_east.y, south_west.y, south_east.y, column.z, row.z);
    imageStore(improved, site.y * width + site.x, vec4(x, y, 0.0, 0.0));
  }
}
