#version 120
#extension GL_ARB_texture_rectangle : require
// What a level begins with: the displacement of the one before, projected, and in texels of one site 1 / modulus, which
// sweep.frag hands on.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE

uniform sampler2DRect coarse;      // displacement
uniform sampler2DRect observation; // of this level, a: 1 / modulus; not where PAIRS is defined
uniform sampler2DRect table;       // backends/shared/resampling_entries.hpp, of the columns in row 0, of the rows in row 1

#include "projection.inc"
#include "two_sites.glsl"

// Of the site with the pixel centre p.
vec2 first_displacement(vec2 p) {
  vec3 to_centres = vec3(0.5, 0.5, 0.0);
  vec3 column = texture2DRect(table, vec2(p.x, 0.5)).rgb + to_centres;
  vec3 row = texture2DRect(table, vec2(p.y, 1.5)).rgb + to_centres;
  vec2 north_west = site_in(coarse, vec2(column.r, row.r));
  vec2 north_east = site_in(coarse, vec2(column.g, row.r));
  vec2 south_west = site_in(coarse, vec2(column.r, row.g));
  vec2 south_east = site_in(coarse, vec2(column.g, row.g));
  return vec2(projected(north_west.x, north_east.x, south_west.x, south_east.x, column.b, row.b),
              projected(north_west.y, north_east.y, south_west.y, south_east.y, column.b, row.b));
}

void main() {
#ifdef PAIRS
  vec2 site = vec2(2.0 * floor(gl_FragCoord.x) + 0.5, gl_FragCoord.y);
  gl_FragColor = vec4(first_displacement(site), first_displacement(site + vec2(1.0, 0.0)));
#else
  gl_FragColor =
      vec4(first_displacement(gl_FragCoord.xy), texture2DRect(observation, gl_FragCoord.xy).a, 0.0);
#endif
}
