#version 120
#extension GL_ARB_texture_rectangle : require
// A step of the elastic energy for the sites of a level, a fragment each, as the thesis's card could draw it: float
// rectangle textures, of which one is drawn and the others are read. Textures of a level are as large as
// ElasticLayout::padded() says: site (x, y) is texel (x + 1, y + 1), and what is around stays 0. Sums begin at texel 0.
// GLSL 1.20 has no `precise`: the order in the texts must be one that compilers keep.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE
#define HDM_NUMBER(value) float(value)

#include "elastic_steps.h"

uniform sampler2DRect from;
uniform sampler2DRect second;
uniform sampler2DRect moments;
uniform sampler2DRect more;
uniform sampler2DRect response;
uniform sampler2DRect matrices; // of ELASTIC_SOLVE the inverse: a row for each of its columns, rg: x and y of a site
uniform vec2 extent;            // sites of `from`
uniform vec4 numbers;           // the two of PoissonRatio, factor

#include "elastic/cell.inc"
#include "elastic/site.inc"

// Rows of 64.
vec4 matrix_at(float number, int i) {
  float row = floor(number / 64.0);
  return texture2DRect(matrices, vec2(16.0 * (number - 64.0 * row) + float(i), row) + 0.5);
}

#include "elastic.glsl"

#if STEP == ELASTIC_RELAX || STEP == ELASTIC_RESIDUAL
vec2 value_at(vec2 p) { return texture2DRect(from, p).xy; }

CellForces forces_of(vec2 p, vec2 top_left, vec2 top_right, vec2 bottom_left, vec2 bottom_right) {
  return forces_of_cell(HAS_MASKED != 0, texture2DRect(moments, p), texture2DRect(more, p), top_left, top_right, bottom_left,
                        bottom_right, PoissonRatio(numbers.x, numbers.y));
}

void main() {
  vec2 p = gl_FragCoord.xy;
  vec2 north_west = value_at(p + vec2(-1.0, -1.0));
  vec2 north = value_at(p + vec2(0.0, -1.0));
  vec2 north_east = value_at(p + vec2(1.0, -1.0));
  vec2 west = value_at(p + vec2(-1.0, 0.0));
  vec2 centre = value_at(p);
  vec2 east = value_at(p + vec2(1.0, 0.0));
  vec2 south_west = value_at(p + vec2(-1.0, 1.0));
  vec2 south = value_at(p + vec2(0.0, 1.0));
  vec2 south_east = value_at(p + vec2(1.0, 1.0));
  Force force = sum_of_cells(forces_of(p + vec2(-1.0, -1.0), north_west, north, west, centre).bottom_right,
                             forces_of(p + vec2(0.0, -1.0), north, north_east, centre, east).bottom_left,
                             forces_of(p + vec2(-1.0, 0.0), west, centre, south_west, south).top_right,
                             forces_of(p, centre, east, south, south_east).top_left);
#if HAS_LOAD
  vec2 load = texture2DRect(second, p).xy;
  force = residual_of(Force(load.x, load.y), force);
#endif
#if STEP == ELASTIC_RELAX
  vec2 result = relaxed_site(centre, texture2DRect(response, p), force);
#elif IS_IMAGE
  vec2 result = free_parts(vec2(force.x, force.y), texture2DRect(response, p));
#else
  vec2 result = vec2(force.x, force.y);
#endif
  gl_FragColor = vec4(result, 0.0, 0.0);
}

#elif STEP == ELASTIC_RELAX_FROM_ZERO
void main() {
  vec2 load = texture2DRect(from, gl_FragCoord.xy).xy;
  vec2 result = relaxed_site(vec2(0.0), texture2DRect(response, gl_FragCoord.xy), Force(load.x, load.y));
  gl_FragColor = vec4(result, 0.0, 0.0);
}

#elif STEP == ELASTIC_RESTRICT
vec2 fine_at(vec2 p) {
#if IS_IMAGE
  return free_parts(texture2DRect(from, p).xy, texture2DRect(response, p));
#else
  return texture2DRect(from, p).xy;
#endif
}

vec2 restricted_row(vec2 p) {
  return restricted_sites(fine_at(p + vec2(-1.0, 0.0)), fine_at(p), fine_at(p + vec2(1.0, 0.0)));
}

void main() {
  vec2 p = 2.0 * floor(gl_FragCoord.xy) - 0.5; // the texel of fine site 2 x, 2 y
  vec2 result = restricted_sites(restricted_row(p + vec2(0.0, -1.0)), restricted_row(p), restricted_row(p + vec2(0.0, 1.0)));
  gl_FragColor = vec4(result, 0.0, 0.0);
}

#elif STEP == ELASTIC_INTERPOLATE || STEP == ELASTIC_CORRECT
void main() {
  vec2 site = floor(gl_FragCoord.xy) - 1.0;
  vec2 coarse = floor(0.5 * site);
  vec2 odd = site - 2.0 * coarse;
  vec2 north_west = coarse + 1.5;
#if STEP == ELASTIC_CORRECT
  vec2 value = texture2DRect(from, gl_FragCoord.xy).xy;
#else
  vec2 value = vec2(0.0);
#endif
  vec2 result = corrected_site(value, odd.x > 0.5, odd.y > 0.5, texture2DRect(second, north_west).xy,
                               texture2DRect(second, north_west + vec2(odd.x, 0.0)).xy,
                               texture2DRect(second, north_west + vec2(0.0, odd.y)).xy,
                               texture2DRect(second, north_west + odd).xy);
#if IS_IMAGE
  vec4 straight = texture2DRect(response, gl_FragCoord.xy);
  result.x = straight.x > 0.0 ? result.x : value.x;
  result.y = straight.z > 0.0 ? result.y : value.y;
#endif
  gl_FragColor = vec4(result, 0.0, 0.0);
}

#elif STEP == ELASTIC_SOLVE
void main() {
  vec2 at = floor(gl_FragCoord.xy) - 1.0;
  float row = at.y * extent.x + at.x + 0.5;
  float column = 0.5;
  vec2 sum = vec2(0.0);
  for (float y = 1.5; y < extent.y + 1.0; y += 1.0) {
    for (float x = 1.5; x < extent.x + 1.0; x += 1.0) {
      vec2 load = texture2DRect(from, vec2(x, y)).xy;
      vec2 by_x = texture2DRect(matrices, vec2(row, column)).xy;
      vec2 by_y = texture2DRect(matrices, vec2(row, column + 1.0)).xy;
      sum = vec2(with_term(sum.x, by_x.x, load.x), with_term(sum.y, by_x.y, load.x));
      sum = vec2(with_term(sum.x, by_y.x, load.y), with_term(sum.y, by_y.y, load.y));
      column += 2.0;
    }
  }
  gl_FragColor = vec4(sum, 0.0, 0.0);
}

#elif STEP == ELASTIC_ADVANCE
void main() {
  vec2 value = texture2DRect(from, gl_FragCoord.xy).xy;
  vec2 direction = texture2DRect(second, gl_FragCoord.xy).xy;
  gl_FragColor = vec4(advanced(value.x, numbers.z, direction.x), advanced(value.y, numbers.z, direction.y), 0.0, 0.0);
}

#else
// Of what is summed up, 0 beyond its border; p counts from 0.
real term_at(vec2 p) {
#if STEP == ELASTIC_PRODUCTS
  vec2 value = texture2DRect(from, p + 1.5).xy;
  vec2 other = texture2DRect(second, p + 1.5).xy;
  real term = site_product(value.x, other.x, value.y, other.y);
#else
  real term = texture2DRect(from, p + 0.5).x;
#endif
  return p.x < extent.x && p.y < extent.y ? term : 0.0;
}
// One level of the tree in a pass: compilers without `precise` balance larger sums anew.
void main() {
  vec2 p = 2.0 * floor(gl_FragCoord.xy);
  gl_FragColor = vec4(square_sum(term_at(p), term_at(p + vec2(1.0, 0.0)), term_at(p + vec2(0.0, 1.0)), term_at(p + 1.0)));
}
#endif
