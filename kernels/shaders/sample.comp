#version 430
#extension GL_GOOGLE_include_directive : require

// A level's moduli, targets and confidences at the sites of the full image that it samples, an invocation per site.

layout(local_size_x = 64) in;

#include "resampling.glsl"

layout(binding = 1, rg32f) uniform restrict writeonly imageBuffer sampled_material;
layout(binding = 2, rgba32f) uniform restrict writeonly imageBuffer sampled_observation;

void main() {
  ivec2 site = ivec2(gl_GlobalInvocationID.xy);
  if (site.x < width) {
    int from = int(row_entry(site.y).w) * from_width + int(column_entry(site.x).w);
    int to = site.y * width + site.x;
    imageStore(sampled_material, to, texelFetch(material, from));
    imageStore(sampled_observation, to, texelFetch(observation, from));
  }
}
