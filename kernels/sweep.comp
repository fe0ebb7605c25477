#version 430
// One sweep as an OpenGL 4.3 compute shader. Buffer textures: on rasterizers that run on the CPU
// their fetches are several times faster than storage buffers and twice as fast as two-dimensional textures.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define POSITION ivec2

layout(local_size_x = 64, local_size_y = 1) in;

layout(binding = 0) uniform samplerBuffer image;       // rg: displacement
layout(binding = 1) uniform samplerBuffer observation; // rg: target, b: modulus, a: 1 / modulus
layout(binding = 2) uniform samplerBuffer confidence;  // rg, ba: 1 / curvature where the rule needs it
layout(binding = 0, rg32f) uniform restrict writeonly imageBuffer next_image;
layout(location = 0) uniform ivec2 dimension;
layout(location = 1) uniform float penalty;
layout(location = 2) uniform float steps[16];
layout(location = 18) uniform vec4 turn; // colour, strength, number, seed of update.inc's Sweep
const int rule = RULE; // this and the next two are supplied after #version
const int colours = COLOURS;
const int step_count = STEP_COUNT;

int index_of(ivec2 p) { return p.y * dimension.x + p.x; }
vec2 displacement_at(ivec2 p) { return texelFetch(image, index_of(p)).rg; }
float inverse_modulus_at(ivec2 p) { return texelFetch(observation, index_of(p)).a; }
vec3 observation_at(ivec2 p) { return texelFetch(observation, index_of(p)).rgb; }
vec4 confidence_at(ivec2 p) { return texelFetch(confidence, index_of(p)); }

#include "energy.inc"
#include "update.inc"
#include "gather.glsl"

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (at.x < dimension.x) {
    Displacement next =
        swept_displacement(rule, colours, gather(at, dimension, penalty), Position(float(at.x), float(at.y)),
                           Sweep(turn.x, turn.y, turn.z, turn.w), steps, step_count);
    imageStore(next_image, index_of(at), vec4(next.x, next.y, 0.0, 0.0));
  }
}
