#version 120
#extension GL_ARB_texture_rectangle : require
// One sweep as the thesis ran its iterations: GLSL 1.20, float rectangle textures, two of them swapped (Tab. 6.1, 6.2,
// Alg. 4). GLSL 1.20 has no `precise`: the order in energy.inc must be one that compilers keep.

#define real float
#define HDM_FUNCTION
#define HDM_CONSTANT const
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

// Tiles of the image of which more is known (tile_class.inc) are drawn with a constant defined for
// it, and fetch less: INTERIOR (gather.glsl, not border), HOMOGENEOUS (not elastic), UNOBSERVED (not observed).
vec2 displacement_at(vec2 p) { return texture2DRect(image, p).rg; }
#ifdef HOMOGENEOUS
float inverse_modulus_at(vec2 p) { return 1.0; }
#else
float inverse_modulus_at(vec2 p) { return texture2DRect(image, p).b; }
#endif
#if defined(HOMOGENEOUS) && defined(UNOBSERVED)
vec3 observation_at(vec2 p) { return vec3(0.0, 0.0, 1.0); }
#elif defined(HOMOGENEOUS)
vec3 observation_at(vec2 p) { return vec3(texture2DRect(observation, p).rg, 1.0); }
#else
vec3 observation_at(vec2 p) { return texture2DRect(observation, p).rgb; }
#endif
#ifdef UNOBSERVED
const bool observed = false;
vec4 confidence_at(vec2 p) { return vec4(0.0); }
#else
const bool observed = true;
vec4 confidence_at(vec2 p) { return texture2DRect(confidence, p); }
#endif

#if HDM_INPUTS > 0
uniform sampler2DRect inputs; // the energy's own
vec4 inputs_at(vec2 p) { return texture2DRect(inputs, p); }
#endif

#include "site.inc"
#include "energy.inc"
#include "update.inc"
#include "gather.glsl"

void main() {
  Displacement next = swept_displacement(rule, colours, observed, gather(gl_FragCoord.xy, dimension, penalty),
                                         Position(floor(gl_FragCoord.x), floor(gl_FragCoord.y)),
                                         Sweep(turn.x, turn.y, turn.z, turn.w), steps, step_count);
  gl_FragColor = vec4(next.x, next.y, texture2DRect(image, gl_FragCoord.xy).b, 0.0);
}
