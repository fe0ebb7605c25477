#version 450
#extension GL_GOOGLE_include_directive : require

// Adds to `changed` the number of sites at which two displacements differ in value (-0 equals 0), an invocation per
// site.

layout(local_size_x = 64) in;

#include "tile_size.vulkan.h"
#include "level.vulkan.glsl"

void main() {
  ivec2 site = ivec2(gl_GlobalInvocationID.xy);
  if (site.x < width) {
    int index = index_of(site);
    if (any(notEqual(texelFetch(displacement, index).xy, imageLoad(improved, index).xy))) {
      atomicAdd(changed, 1u);
    }
  }
}
