#version 120
#extension GL_ARB_texture_rectangle : require
// The sites of the full image that a level samples.

uniform sampler2DRect full;
uniform sampler2DRect table; // backends/shared/resampling_entries.hpp, of the columns in row 0, of the rows in row 1

#include "two_sites.glsl"

// Centre of the pixel that is sampled for the one with the centre p.
vec2 sampled(vec2 p) {
  return vec2(texture2DRect(table, vec2(p.x, 0.5)).a, texture2DRect(table, vec2(p.y, 1.5)).a) + vec2(0.5);
}

void main() {
#ifdef PAIRS
  vec2 site = vec2(2.0 * floor(gl_FragCoord.x) + 0.5, gl_FragCoord.y);
  gl_FragColor = vec4(site_in(full, sampled(site)), site_in(full, sampled(site + vec2(1.0, 0.0))));
#else
  gl_FragColor = texture2DRect(full, sampled(gl_FragCoord.xy));
#endif
}
