#version 450
#extension GL_GOOGLE_include_directive : require

// One sweep, an invocation per site. Texel buffers because software rasterizers read them
// several times faster than storage buffers. backends/vulkan/session.cpp fixes the bindings and the block's layout.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define POSITION ivec2

layout(local_size_x = 64) in;
layout(constant_id = 0) const int rule = 0;
layout(constant_id = 1) const int colours = 1;
layout(constant_id = 2) const int step_count = 1;

layout(set = 0, binding = 0) uniform textureBuffer displacement;
layout(set = 0, binding = 1) uniform textureBuffer observation;
layout(set = 0, binding = 2) uniform textureBuffer confidence;
layout(set = 0, binding = 3, rg32f) uniform restrict writeonly imageBuffer improved;

layout(push_constant) uniform Parameters {
  float steps[16];
  float penalty;
  int width;
  int height;
  float colour; // from here on update.inc's Sweep
  float strength;
  float number;
  float seed;
};

int index_of(ivec2 site) { return site.y * width + site.x; }
vec2 displacement_at(ivec2 site) { return texelFetch(displacement, index_of(site)).xy; }
float inverse_modulus_at(ivec2 site) { return texelFetch(observation, index_of(site)).w; }
vec3 observation_at(ivec2 site) { return texelFetch(observation, index_of(site)).xyz; }
vec4 confidence_at(ivec2 site) { return texelFetch(confidence, index_of(site)); }

#include "energy.inc"
#include "update.inc"
#include "gather.glsl"

void main() {
  ivec2 site = ivec2(gl_GlobalInvocationID.xy);
  if (site.x < width) {
    Displacement next = swept_displacement(rule, colours, gather(site, ivec2(width, height), penalty),
                                           Position(float(site.x), float(site.y)),
                                           Sweep(colour, strength, number, seed), steps, step_count);
    imageStore(improved, index_of(site), vec4(next.x, next.y, 0.0, 0.0));
  }
}
