#version 430
// Copies texels: how fast a compute shader moves memory. For OpenGL and Vulkan.

layout(local_size_x = 64) in;

layout(binding = 7) uniform samplerBuffer source;
layout(binding = 0, rgba32f) uniform restrict writeonly imageBuffer target;

void main() {
  int index = int(gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x);
  imageStore(target, index, texelFetch(source, index));
}
