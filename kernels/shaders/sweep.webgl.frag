#version 300 es
// The thesis's sweep (sweep.frag) in the language of WebGL 2, where a browser translates it once more for the driver.
// GLSL ES 3.00 has no `precise`.

precision highp float;
precision highp int;
precision highp sampler2D;

#define real float
#define HDM_FUNCTION
#define HDM_CONSTANT const
#define HDM_PRECISE
#define POSITION ivec2

uniform sampler2D image;       // rg: displacement, b: 1 / modulus, handed on
uniform sampler2D observation; // rg: target, b: modulus
uniform sampler2D confidence;  // rg, ba: 1 / curvature where the rule needs it
uniform ivec2 dimension;
uniform float penalty;
uniform float steps[16];
uniform vec4 turn;             // colour, strength, number, seed of update.inc's Sweep
const int rule = RULE;         // this and the next two are supplied after #version
const int colours = COLOURS;
const int step_count = STEP_COUNT;

out vec4 swept;

vec2 displacement_at(ivec2 p) { return texelFetch(image, p, 0).rg; }
float inverse_modulus_at(ivec2 p) { return texelFetch(image, p, 0).b; }
vec3 observation_at(ivec2 p) { return texelFetch(observation, p, 0).rgb; }
vec4 confidence_at(ivec2 p) { return texelFetch(confidence, p, 0); }

#include "site.inc"
#include "energy.inc"
#include "update.inc"
#include "gather.glsl"

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  Displacement next = swept_displacement(rule, colours, true, gather(at, dimension, penalty),
                                         Position(float(at.x), float(at.y)), Sweep(turn.x, turn.y, turn.z, turn.w),
                                         steps, step_count);
  swept = vec4(next.x, next.y, texelFetch(image, at, 0).b, 0.0);
}
