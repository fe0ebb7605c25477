#version 430
#extension GL_GOOGLE_include_directive : require

// What is done once to every site of a level, an invocation each. The entries are backends/session/level_arrays.hpp's.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise

#include "level_passes.h"

#ifdef VULKAN
layout(constant_id = 0) const int pass = 0;
#else
const int pass = PASS;
#endif
layout(local_size_x = 64) in;

#include "fields.glsl"

layout(binding = 1, rg32f) uniform restrict writeonly imageBuffer sampled_material;
layout(binding = 2, rgba32f) uniform restrict writeonly imageBuffer sampled_observation;
layout(binding = 4, std430) buffer Counter { uint changed; };

PARAMETERS(8) // LevelPass of backends/session/device_session.cpp, which has more for planes
#define width parameters[0]
#define from_width parameters[3]

vec4 column_entry(int column) { return texelFetch(entries, parameters[6] + column); }
vec4 row_entry(int row) { return texelFetch(entries, parameters[7] + row); }
vec2 displacement_at(int i) { return texelFetch(displacement, i).xy; }

#include "projection.glsl"

void main() {
  ivec2 site = ivec2(gl_GlobalInvocationID.xy);
  int to = site.y * width + site.x;
  if (site.x >= width) {
    return;
  }
  if (pass == LEVEL_COUNT) {
    if (displacement_at(to) != imageLoad(improved, to).xy) {
      atomicAdd(changed, 1u);
    }
    return;
  }
  vec4 column = column_entry(site.x);
  vec4 row = row_entry(site.y);
  if (pass == LEVEL_SAMPLE) {
    int from = int(row.w) * from_width + int(column.w);
    imageStore(sampled_material, to, texelFetch(material, from));
    imageStore(sampled_observation, to, texelFetch(observation, from));
  } else {
    vec2 between = projected_displacement(from_width, column, row);
    imageStore(improved, to, vec4(between, 0.0, 0.0));
  }
}
