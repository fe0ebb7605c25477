#version 430
// What a coarse level keeps of the full one: the values of the sites that it samples (pyramid.hpp).

layout(local_size_x = 64) in;

layout(binding = 0) uniform samplerBuffer full_material;
layout(binding = 1) uniform samplerBuffer full_observation;
layout(binding = 0, rg32f) uniform restrict writeonly imageBuffer material;
layout(binding = 1, rgba32f) uniform restrict writeonly imageBuffer observation;
layout(binding = 0, std430) restrict readonly buffer Sampled { int sampled[]; }; // per column, then per row
layout(location = 0) uniform ivec2 dimension;
layout(location = 1) uniform int full_width;

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (at.x < dimension.x) {
    int from = sampled[dimension.x + at.y] * full_width + sampled[at.x];
    int index = at.y * dimension.x + at.x;
    imageStore(material, index, texelFetch(full_material, from));
    imageStore(observation, index, texelFetch(full_observation, from));
  }
}
