#version 120
#extension GL_ARB_texture_rectangle : require
// One sweep as the thesis ran its iterations: GLSL 1.20, float rectangle textures, a quad per sweep (Tab. 6.1, 6.2,
// Alg. 4). GLSL 1.20 has no `precise`: the order in energy.inc must be one that compilers keep.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE
#define POSITION vec2

uniform sampler2DRect image;       // rg: displacement, b: 1 / modulus, handed on: a neighbour costs one fetch
uniform sampler2DRect observation; // rg: target, b: modulus
uniform sampler2DRect confidence;  // rg, ba: 1 / curvature where the rule needs it
uniform vec2 dimension;
uniform float penalty;
uniform float steps[16];
uniform vec4 turn;                 // colour, strength, number, seed of update.inc's Sweep
const int rule = RULE;             // this and the next two are supplied after #version
const int colours = COLOURS;
const int step_count = STEP_COUNT;

vec2 displacement_at(vec2 p) { return texture2DRect(image, p).rg; }
float inverse_modulus_at(vec2 p) { return texture2DRect(image, p).b; }
vec3 observation_at(vec2 p) { return texture2DRect(observation, p).rgb; }
vec4 confidence_at(vec2 p) { return texture2DRect(confidence, p); }

#include "energy.inc"
#include "update.inc"
#include "gather.glsl"

void main() {
  Displacement next = swept_displacement(rule, colours, gather(gl_FragCoord.xy, dimension, penalty),
                                         Position(floor(gl_FragCoord.x), floor(gl_FragCoord.y)),
                                         Sweep(turn.x, turn.y, turn.z, turn.w), steps, step_count);
  gl_FragColor = vec4(next.x, next.y, inverse_modulus_at(gl_FragCoord.xy), 0.0);
}
