#version 120
#extension GL_ARB_texture_rectangle : require
#include "precise.glsl"
// One sweep as the thesis ran its iterations: GLSL 1.20, float rectangle textures, two of them swapped (Tab. 6.1, 6.2,
// Alg. 4). Or, where PAIRS is defined, by candidates that are constants in texels of two sites, columns 2i and 2i + 1: two
// displacements fill a texel, and a fetch costs a rasterizer that runs on the CPU as much as thirty operations. Of a volume
// a slice is drawn, and a texel has room for a displacement of three numbers.

#define real float
#define HDM_FUNCTION
#define HDM_CONSTANT const

#include "axes.glsl"

uniform sampler2DRect image;       // rg: displacement, b: 1 / modulus, handed on: a neighbour costs one fetch.
                                   // Of pairs rg, ba: displacement of the first and the second site
uniform sampler2DRect observation; // a texel per site. rg: target, b: modulus. Of pairs ba: confidence
                                   // Of a volume rgb and a in both
uniform Vector dimension;          // in sites
uniform float penalty;
uniform vec4 turn;     // colour, strength, number, seed of update.inc's Sweep
const int rule = RULE; // this and the next two are supplied after #version
const int colours = COLOURS;
const int step_count = STEP_COUNT;

// Tiles of the image of which more is known (backends/shared/tiles.hpp) are drawn with a constant defined for
// it, and fetch less: INTERIOR (gather.glsl, not border), HOMOGENEOUS (not elastic), UNOBSERVED (not observed).
#ifdef UNOBSERVED
const bool observed = false;
#else
const bool observed = true;
#endif

#ifdef PAIRS
uniform sampler2DRect material; // rg, ba: 1 / modulus and modulus of the first and the second site
const float steps[16] = float[16](STEPS);

#include "two_sites.glsl"

vec2 first_site() { return vec2(2.0 * floor(gl_FragCoord.x) + 0.5, gl_FragCoord.y); }

#ifdef INTERIOR
#define POSITION ivec2 // in a window of 4 x 3 sites, the two in the middle
vec2 displacements[12];
vec2 materials[12];
vec2 displacement_at(ivec2 p) { return displacements[4 * p.y + p.x]; }
vec2 material_at(ivec2 p) { return materials[4 * p.y + p.x]; }
vec2 pixel_of(ivec2 p) { return first_site() + vec2(p - ivec2(1)); }
ivec2 site(int k) { return ivec2(1 + k, 1); }
#else
#define POSITION vec2 // the pixel: its neighbour may be itself
vec2 displacement_at(vec2 p) { return site_in(image, p); }
vec2 material_at(vec2 p) { return site_in(material, p); }
vec2 pixel_of(vec2 p) { return p; }
vec2 site(int k) { return first_site() + vec2(float(k), 0.0); }
#endif
#ifdef HOMOGENEOUS
float inverse_modulus_at(POSITION p) { return 1.0; }
float modulus_at(POSITION p) { return 1.0; }
#else
float inverse_modulus_at(POSITION p) { return material_at(p).x; }
float modulus_at(POSITION p) { return material_at(p).y; }
#endif
#ifdef UNOBSERVED
vec4 observed_at(POSITION p) { return vec4(0.0); }
#else
vec4 observed_at(POSITION p) { return texture2DRect(observation, pixel_of(p)); }
#endif
vec3 observation_at(POSITION p) { return vec3(observed_at(p).rg, modulus_at(p)); }
vec4 confidence_at(POSITION p) { return vec4(observed_at(p).ba, 0.0, 0.0); }

#else
#define POSITION Vector
uniform sampler2DRect confidence; // rg, ba: 1 / curvature where the rule needs it; of a volume rgb
uniform float steps[16];

#if HDM_AXES > 2
uniform sampler2DRect curvature; // rgb: 1 / curvature where the rule needs it
uniform vec3 slices;             // slices.glsl
uniform float slice;             // that is drawn
#include "slices.glsl"
vec2 pixel_of(vec3 p) { return texel_of(p, slices); }
vec3 site_drawn() { return vec3(gl_FragCoord.xy - texel_of(vec3(0.0, 0.0, slice), slices), slice); }
vec3 inverse_curvature_at(vec3 p) { return texture2DRect(curvature, pixel_of(p)).rgb; }
#else
vec2 pixel_of(vec2 p) { return p; }
vec2 site_drawn() { return gl_FragCoord.xy; }
#endif
Vector displacement_at(Vector p) { return texture2DRect(image, pixel_of(p)).COMPONENTS; }
#ifdef HOMOGENEOUS
float inverse_modulus_at(Vector p) { return 1.0; }
#else
float inverse_modulus_at(Vector p) { return texture2DRect(image, pixel_of(p)).MODULUS; }
#endif
#if defined(HOMOGENEOUS) && defined(UNOBSERVED)
WithModulus observation_at(Vector p) { return WithModulus(Vector(0.0), 1.0); }
#elif defined(HOMOGENEOUS)
WithModulus observation_at(Vector p) { return WithModulus(texture2DRect(observation, pixel_of(p)).COMPONENTS, 1.0); }
#else
WithModulus observation_at(Vector p) { return WithModulus(texture2DRect(observation, pixel_of(p))); }
#endif
#ifdef UNOBSERVED
vec4 confidence_at(Vector p) { return vec4(0.0); }
#else
vec4 confidence_at(Vector p) { return texture2DRect(confidence, pixel_of(p)); }
#endif
#endif

#if HDM_INPUTS > 0
uniform sampler2DRect inputs; // the energy's own, a texel per site
vec4 inputs_at(POSITION p) { return texture2DRect(inputs, pixel_of(p)); }
#endif

#include "site.inc"
#include "energy.inc"
#include "update.inc"
#include "gather.glsl"

Displacement swept(POSITION p) {
#ifdef PAIRS
  vec2 place = pixel_of(p);
#else
  Vector place = p;
#endif
  return swept_displacement(rule, colours, observed, gather(p, POSITION(dimension), penalty),
                            Position(floor(place.x), floor(place.y) AND_Z(place.z)), Sweep(turn.x, turn.y, turn.z, turn.w),
                            steps, step_count);
}

#if defined(PAIRS) && defined(INTERIOR)
// Fetches a row of the window: 4 sites, of three texels.
void fetch_row(int row, float offset) {
  vec4 middle = texture2DRect(image, gl_FragCoord.xy + vec2(0.0, offset));
  displacements[4 * row] = texture2DRect(image, gl_FragCoord.xy + vec2(-1.0, offset)).ba;
  displacements[4 * row + 1] = middle.rg;
  displacements[4 * row + 2] = middle.ba;
  displacements[4 * row + 3] = texture2DRect(image, gl_FragCoord.xy + vec2(1.0, offset)).rg;
#ifndef HOMOGENEOUS
  middle = texture2DRect(material, gl_FragCoord.xy + vec2(0.0, offset));
  materials[4 * row] = texture2DRect(material, gl_FragCoord.xy + vec2(-1.0, offset)).ba;
  materials[4 * row + 1] = middle.rg;
  materials[4 * row + 2] = middle.ba;
  materials[4 * row + 3] = texture2DRect(material, gl_FragCoord.xy + vec2(1.0, offset)).rg;
#endif
}
#endif

void main() {
#ifdef PAIRS
#ifdef INTERIOR
  fetch_row(0, -1.0);
  fetch_row(1, 0.0);
  fetch_row(2, 1.0);
#endif
  Displacement next = swept(site(0));
  Displacement second = swept(site(1));
  vec2 rest = vec2(second.x, second.y);
#ifndef INTERIOR // of an odd width the last texel's second site is beyond the image: it is handed on and never changes
  if (first_site().x + 1.0 > dimension.x) {
    rest = texture2DRect(image, gl_FragCoord.xy).ba;
  }
#endif
#else
  Displacement next = swept(site_drawn());
  vec2 rest = vec2(texture2DRect(image, gl_FragCoord.xy).MODULUS, 0.0);
#endif
  gl_FragColor = vec4(next.x, next.y AND_Z(next.z), rest);
}
