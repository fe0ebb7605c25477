#version 120
#extension GL_ARB_texture_rectangle : require
// The fragment path's passes beside the sweep, one by the constant that is defined.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE

uniform sampler2DRect image;
uniform sampler2DRect previous; // the image before the last sweep
uniform sampler2DRect table;    // backends/session/level_arrays.hpp, of the columns in row 0, of the rows in row 1

#include "two_sites.glsl"

#if defined(CELL)
// Whether the last sweep changed any site of a cell of CELL x CELL texels, a texel per cell. Drawn for the tiles that were
// awake; in those that were not, nothing changed the last time either.
void main() {
  vec2 first = floor(gl_FragCoord.xy) * float(CELL) + vec2(0.5);
  bool changed = false;
  for (int y = 0; y < CELL; ++y) {
    for (int x = 0; x < CELL; ++x) {
      vec2 texel = first + vec2(float(x), float(y));
      changed = changed || texture2DRect(image, texel) != texture2DRect(previous, texel);
    }
  }
  gl_FragColor = vec4(float(changed));
}

#elif defined(CELLS)
// Whether anything can change in a tile, a texel per tile: whether the last sweep changed something in its CELLS x CELLS
// cells or in those around them. Beyond the image's border the nearest cell is fetched, which is one of them.
void main() {
  vec2 first = floor(gl_FragCoord.xy) * float(CELLS) - vec2(0.5);
  float changed = 0.0;
  for (int y = 0; y < CELLS + 2; ++y) {
    for (int x = 0; x < CELLS + 2; ++x) {
      changed = max(changed, texture2DRect(image, first + vec2(float(x), float(y))).r);
    }
  }
  gl_FragColor = vec4(changed);
}

#elif defined(COUNTS)
// Lets a fragment pass where the last iteration changed the displacement, a fragment per site: an occlusion query counts.
void main() {
  vec2 now = site_in(image, gl_FragCoord.xy);
  vec2 before = site_in(previous, gl_FragCoord.xy);
  if (now == before) {
    discard;
  }
  gl_FragColor = vec4(1.0);
}

#elif defined(SAMPLES) || defined(PROJECTS)
#ifdef SAMPLES
// The sites of the full image that a level samples.
vec2 sampled(vec2 p) {
  return vec2(texture2DRect(table, vec2(p.x, 0.5)).a, texture2DRect(table, vec2(p.y, 1.5)).a) + vec2(0.5);
}
vec2 value_at(vec2 p) { return site_in(image, sampled(p)); }
vec4 texel_at(vec2 p) { return texture2DRect(image, sampled(p)); }
#else
// What a level begins with: the displacement of the one before, projected, and in texels of one site 1 / modulus, which
// sweep.frag hands on.
uniform sampler2DRect observation; // of this level, a: 1 / modulus; not where PAIRS is defined

#include "projection.inc"

vec2 value_at(vec2 p) {
  vec3 to_centres = vec3(0.5, 0.5, 0.0);
  vec3 column = texture2DRect(table, vec2(p.x, 0.5)).rgb + to_centres;
  vec3 row = texture2DRect(table, vec2(p.y, 1.5)).rgb + to_centres;
  vec2 north_west = site_in(image, vec2(column.r, row.r));
  vec2 north_east = site_in(image, vec2(column.g, row.r));
  vec2 south_west = site_in(image, vec2(column.r, row.g));
  vec2 south_east = site_in(image, vec2(column.g, row.g));
  return vec2(projected(north_west.x, north_east.x, south_west.x, south_east.x, column.b, row.b),
              projected(north_west.y, north_east.y, south_west.y, south_east.y, column.b, row.b));
}
vec4 texel_at(vec2 p) { return vec4(value_at(p), texture2DRect(observation, p).a, 0.0); }
#endif

void main() {
#ifdef PAIRS
  vec2 site = vec2(2.0 * floor(gl_FragCoord.x) + 0.5, gl_FragCoord.y);
  gl_FragColor = vec4(value_at(site), value_at(site + vec2(1.0, 0.0)));
#else
  gl_FragColor = texel_at(gl_FragCoord.xy);
#endif
}

#else
// Loops that probe and measure a device; backends/session/device_loops.cpp knows what comes out.
#include "level_passes.h"
#include "probe.inc"

#define ROUND a = a * factor + term; b = b * factor + term; c = c * factor + term;

void main() {
#if LOOP == LOOP_PROBE // two texels side by side: a, b, c, d; e, operation
  vec2 at = vec2(2.0 * floor(gl_FragCoord.x) + 0.5, gl_FragCoord.y);
  vec4 first = texture2DRect(image, at);
  vec4 second = texture2DRect(image, at + vec2(1.0, 0.0));
  gl_FragColor = vec4(probed(second.y, first.x, first.y, first.z, first.w, second.x), 0.0, 0.0, 0.0);
#elif LOOP == LOOP_COPY
  gl_FragColor = texture2DRect(image, gl_FragCoord.xy);
#else
  vec4 given = texture2DRect(image, gl_FragCoord.xy);
  float factor = given.z;
  float term = given.w;
  vec4 a = given.x + vec4(0.0, 1.0, 2.0, 3.0);
  vec4 b = given.x + vec4(4.0, 5.0, 6.0, 7.0);
  vec4 c = given.x + vec4(8.0, 9.0, 10.0, 11.0);
  for (int i = 0; i < 64; ++i) {
    ROUND ROUND ROUND ROUND ROUND ROUND ROUND ROUND
  }
  ROUND
  gl_FragColor = a + b + c;
#endif
}
#endif
