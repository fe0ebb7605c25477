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

PARAMETERS(9) // LevelPass of backends/session/device_session.cpp, which has more for planes
#define width parameters[0]
#define height parameters[1]
#define from_size ivec2(parameters[4], parameters[5])
#define first_column parameters[8]

Vector displacement_at(int i) { return texelFetch(displacement, i).COMPONENTS; }

#include "projection.glsl"

void main() {
  ivec3 site = ivec3(gl_GlobalInvocationID);
  int to = (site.z * height + site.y) * width + site.x;
  if (site.x >= width) {
    return;
  }
  if (pass == LEVEL_COUNT) {
    if (displacement_at(to) != imageLoad(improved, to).COMPONENTS) {
      atomicAdd(changed, 1u);
    }
    return;
  }
  vec4 column = texelFetch(entries, first_column + site.x);
  vec4 row = texelFetch(entries, first_column + width + site.y);
  vec4 slice = texelFetch(entries, first_column + width + height + site.z);
  if (pass == LEVEL_SAMPLE) {
    int from = (int(slice.w) * from_size.y + int(row.w)) * from_size.x + int(column.w);
    imageStore(sampled_material, to, texelFetch(material, from));
    for (int i = 0; i < HDM_AXES - 1; ++i) {
      imageStore(sampled_observation, (HDM_AXES - 1) * to + i, texelFetch(observation, (HDM_AXES - 1) * from + i));
    }
  } else {
    imageStore(improved, to, vec4(projected_displacement(from_size, column, row, slice), REST));
  }
}
