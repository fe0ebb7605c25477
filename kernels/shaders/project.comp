#version 430
#extension GL_GOOGLE_include_directive : require

// The displacement a level begins with, from the level computed before it, an invocation per site.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise

layout(local_size_x = 64) in;

#include "resampling.glsl"

vec2 displacement_at(int i) { return texelFetch(displacement, i).xy; }

#include "projection.glsl"

void main() {
  ivec2 site = ivec2(gl_GlobalInvocationID.xy);
  if (site.x < width) {
    vec2 between = projected_displacement(from_width, column_entry(site.x), row_entry(site.y));
    imageStore(improved, site.y * width + site.x, vec4(between, 0.0, 0.0));
  }
}
