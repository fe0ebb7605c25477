#version 120
#extension GL_ARB_texture_rectangle : require
// What a level begins with: the displacement of the one before, projected, and 1 / modulus, which sweep.frag hands on.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE

uniform sampler2DRect coarse;      // rg: displacement
uniform sampler2DRect observation; // of this level, a: 1 / modulus
uniform sampler2DRect table;       // r, g: centres of the two coarse pixels, b: weight of the second one; of the columns
                                   // in row 0, of the rows in row 1

#include "projection.inc"

void main() {
  vec3 column = texture2DRect(table, vec2(gl_FragCoord.x, 0.5)).rgb;
  vec3 row = texture2DRect(table, vec2(gl_FragCoord.y, 1.5)).rgb;
  vec2 north_west = texture2DRect(coarse, vec2(column.r, row.r)).rg;
  vec2 north_east = texture2DRect(coarse, vec2(column.g, row.r)).rg;
  vec2 south_west = texture2DRect(coarse, vec2(column.r, row.g)).rg;
  vec2 south_east = texture2DRect(coarse, vec2(column.g, row.g)).rg;
  gl_FragColor = vec4(projected(north_west.x, north_east.x, south_west.x, south_east.x, column.b, row.b),
                      projected(north_west.y, north_east.y, south_west.y, south_east.y, column.b, row.b),
                      texture2DRect(observation, gl_FragCoord.xy).a, 0.0);
}
