#version 430
#extension GL_GOOGLE_include_directive : require

// Adds to `changed` the number of sites at which two displacements differ in value (-0 equals 0), an invocation per
// site.

layout(local_size_x = 64) in;

#include "fields.glsl"

layout(binding = 4, std430) buffer Counter { uint changed; };

PARAMETERS(1)
#define width parameters[0]

void main() {
  ivec2 site = ivec2(gl_GlobalInvocationID.xy);
  int index = site.y * width + site.x;
  if (site.x < width && texelFetch(displacement, index).xy != imageLoad(improved, index).xy) {
    atomicAdd(changed, 1u);
  }
}
