#version 430
// The displacement a level begins with, from the one of the level above.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise

layout(local_size_x = 64) in;

struct Interpolation { // of pyramid.hpp
  int first;
  int second;
  float weight;
};

layout(binding = 0) uniform samplerBuffer coarse; // rg: displacement
layout(binding = 0, rg32f) uniform restrict writeonly imageBuffer fine;
layout(binding = 0, std430) restrict readonly buffer Axes { Interpolation axes[]; }; // per column, then per row
layout(location = 0) uniform ivec2 dimension;
layout(location = 1) uniform int coarse_width;

#include "projection.inc"

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (at.x < dimension.x) {
    Interpolation x = axes[at.x];
    Interpolation y = axes[dimension.x + at.y];
    vec2 north_west = texelFetch(coarse, y.first * coarse_width + x.first).rg;
    vec2 north_east = texelFetch(coarse, y.first * coarse_width + x.second).rg;
    vec2 south_west = texelFetch(coarse, y.second * coarse_width + x.first).rg;
    vec2 south_east = texelFetch(coarse, y.second * coarse_width + x.second).rg;
    vec2 between =
        vec2(projected(north_west.x, north_east.x, south_west.x, south_east.x, x.weight, y.weight),
             projected(north_west.y, north_east.y, south_west.y, south_east.y, x.weight, y.weight));
    imageStore(fine, at.y * dimension.x + at.x, vec4(between, 0.0, 0.0));
  }
}
