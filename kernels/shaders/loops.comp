#version 430
#extension GL_GOOGLE_include_directive : require

// Loops that probe and measure a device, for OpenGL and Vulkan; backends/session/device_loops.cpp knows what comes out.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise

#include "level_passes.h"

#ifdef VULKAN
layout(constant_id = 0) const int loop = 0;
#else
const int loop = LOOP;
#endif
layout(local_size_x = 64) in;

layout(binding = 7) uniform samplerBuffer source;
layout(binding = 0, rgba32f) uniform restrict writeonly imageBuffer target;

#include "probe.inc"

#define ROUND a = a * factor + term; b = b * factor + term; c = c * factor + term;

vec4 multiplied_and_added(vec4 given) {
  float factor = given.z;
  float term = given.w;
  precise vec4 a = given.x + vec4(0.0, 1.0, 2.0, 3.0);
  precise vec4 b = given.x + vec4(4.0, 5.0, 6.0, 7.0);
  precise vec4 c = given.x + vec4(8.0, 9.0, 10.0, 11.0);
  for (int i = 0; i < 64; ++i) {
    ROUND ROUND ROUND ROUND ROUND ROUND ROUND ROUND
  }
  ROUND
  return a + b + c;
}

void main() {
  int index = int(gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x);
  if (loop == LOOP_PROBE) { // a, b, c, d; e, operation
    vec4 first = texelFetch(source, 2 * index);
    vec4 second = texelFetch(source, 2 * index + 1);
    imageStore(target, index, vec4(probed(second.y, first.x, first.y, first.z, first.w, second.x), 0.0, 0.0, 0.0));
  } else {
    vec4 given = texelFetch(source, index);
    imageStore(target, index, loop == LOOP_COPY ? given : multiplied_and_added(given));
  }
}
