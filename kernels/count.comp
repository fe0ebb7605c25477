#version 430
// Counts the sites whose displacement the last iteration changed.

layout(local_size_x = 64, local_size_y = 1) in;

layout(binding = 0) uniform samplerBuffer image;
layout(binding = 1) uniform samplerBuffer previous;
layout(binding = 0, offset = 0) uniform atomic_uint changed;
layout(location = 0) uniform ivec2 dimension;

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  int index = at.y * dimension.x + at.x;
  if (at.x < dimension.x && texelFetch(image, index).rg != texelFetch(previous, index).rg) {
    atomicCounterIncrement(changed);
  }
}
