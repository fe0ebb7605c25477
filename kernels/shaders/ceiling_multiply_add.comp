#version 430
// Nothing but multiply-adds, apart as the specification has them: how fast a compute shader calculates. For OpenGL and
// Vulkan; backends/shared/ceiling_shaders.cpp knows what comes out.

layout(local_size_x = 64) in;

layout(binding = 7) uniform samplerBuffer source;
layout(binding = 0, rgba32f) uniform restrict writeonly imageBuffer target;

#define ROUND a = a * factor + term; b = b * factor + term; c = c * factor + term;

void main() {
  int index = int(gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x);
  vec4 given = texelFetch(source, index);
  float factor = given.z;
  float term = given.w;
  precise vec4 a = given.x + vec4(0.0, 1.0, 2.0, 3.0);
  precise vec4 b = given.x + vec4(4.0, 5.0, 6.0, 7.0);
  precise vec4 c = given.x + vec4(8.0, 9.0, 10.0, 11.0);
  for (int i = 0; i < 64; ++i) {
    ROUND ROUND ROUND ROUND ROUND ROUND ROUND ROUND
  }
  ROUND
  imageStore(target, index, a + b + c);
}
