#version 430
#extension GL_GOOGLE_include_directive : require
// probe.inc, an invocation for each case. For OpenGL and Vulkan.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise

layout(local_size_x = 64) in;

layout(binding = 7) uniform samplerBuffer source; // a, b, c, d; e, operation
layout(binding = 0, rgba32f) uniform restrict writeonly imageBuffer target;

#include "probe.inc"

void main() {
  int index = int(gl_GlobalInvocationID.x);
  vec4 first = texelFetch(source, 2 * index);
  vec4 second = texelFetch(source, 2 * index + 1);
  imageStore(target, index, vec4(probed(second.y, first.x, first.y, first.z, first.w, second.x), 0.0, 0.0, 0.0));
}
