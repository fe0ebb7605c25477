#version 450
#extension GL_GOOGLE_include_directive : require

// A level's moduli, targets and confidences at the sites of the full image that it samples, an invocation per site.

layout(local_size_x = 64) in;

#include "resampling.vulkan.glsl"

void main() {
  ivec2 site = ivec2(gl_GlobalInvocationID.xy);
  if (site.x < width) {
    int from = int(row_entry(site.y).w) * from_width + int(column_entry(site.x).w);
    int to = site.y * width + site.x;
    imageStore(sampled_material, to, texelFetch(material, from));
    imageStore(sampled_observation, to, texelFetch(observation, from));
  }
}
