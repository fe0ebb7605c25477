#version 120
#extension GL_ARB_texture_rectangle : require
#include "precise.glsl"
// The fragment path's passes beside the sweep, one by the constant that is defined.

#define real float
#define HDM_FUNCTION

uniform sampler2DRect image;
uniform sampler2DRect previous; // the image before the last sweep

#ifdef PAIRS
#include "two_sites.glsl"
#endif

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
#ifdef PAIRS
  bool rests = site_in(image, gl_FragCoord.xy) == site_in(previous, gl_FragCoord.xy);
#else // what is beside the displacement does not change
  bool rests = texture2DRect(image, gl_FragCoord.xy) == texture2DRect(previous, gl_FragCoord.xy);
#endif
  if (rests) {
    discard;
  }
  gl_FragColor = vec4(1.0);
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
