#version 450

// Adds to `changed` the number of sites at which two displacements differ in value (-0 equals 0), an invocation per
// site. Descriptors and push constants are those of sweep.vulkan.comp.

layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform textureBuffer displacement;
layout(set = 0, binding = 3, rg32f) uniform restrict readonly imageBuffer improved;
layout(set = 0, binding = 4, std430) buffer Counter { uint changed; };

layout(push_constant) uniform Parameters {
  float steps[16];
  float penalty;
  int width;
  int height;
};

void main() {
  ivec2 site = ivec2(gl_GlobalInvocationID.xy);
  if (site.x < width) {
    int index = site.y * width + site.x;
    if (any(notEqual(texelFetch(displacement, index).xy, imageLoad(improved, index).xy))) {
      atomicAdd(changed, 1u);
    }
  }
}
