#version 120
#extension GL_ARB_texture_rectangle : require
#include "precise.glsl"
// A step of the elastic energy for the sites of a level, a fragment each, as the thesis's card could draw it: float
// rectangle textures, of which one is drawn and the others are read. Textures of a level are as large as
// ElasticLayout::padded() says: site (x, y) is texel (x + 1, y + 1), of a volume in slice z + 1, and what is around stays 0.
// Sums begin at texel 0.

#define real float
#define HDM_FUNCTION

#include "axes.glsl"
#include "elastic_steps.h"

uniform sampler2DRect from;
uniform sampler2DRect second;
uniform sampler2DRect moments[6];  // of a cell, in the order of CellMoments
uniform sampler2DRect response[2]; // of a site, the upper half of a matrix; in a volume its modulus; at last the number of the
                                   // masked cell that begins there, and 1 more, or 0
uniform sampler2DRect matrices;    // of ELASTIC_SOLVE the inverse: a row for each of its columns, a texel for each site
uniform Vector extent;             // sites of `from`
uniform vec4 law_told;             // the three numbers of Law; of a volume ElasticLevel::bend
uniform vec4 numbers;              // factor; 0

#if HDM_AXES > 2 // no constants: compilers multiply two of them by each other before what stands between them
#define HDM_NUMBER(value) (float(value) + numbers.y)
#else
#define HDM_NUMBER(value) float(value)
#endif

#define HDM_BOXES (BOXES != 0)
#include "elastic/site.inc"
#if HDM_AXES > 2
#include "elastic_volume.glsl"
#else
#include "elastic.glsl"
#endif

// STRIDE is how many sites of the finer level lead from one of the coarser level to the next.
#define STRIDE Vector(1 + HALVED_X, 1 + HALVED_Y AND_Z(1 + HALVED_Z))

// Component by component.
Vector free_parts(Vector residual, Vector straight) {
  return Vector(free_part(residual.x, straight.x),
                free_part(residual.y, straight.y) AND_Z(free_part(residual.z, straight.z)));
}

#if STEP == ELASTIC_RELAX || STEP == ELASTIC_RESIDUAL
void main() {
  Vector p = site_drawn();
  Vector force = force_at(p);
#if HAS_LOAD
  force = level_at(second, p).COMPONENTS + force;
#endif
#if STEP == ELASTIC_RELAX
  force = relaxed_site(level_at(from, p).COMPONENTS, p, force);
#elif IS_IMAGE || HDM_AXES > 2
  force = free_parts(force, straight_at(p));
#endif
  gl_FragColor = vec4(force, REST);
}

#elif STEP == ELASTIC_RELAX_FROM_ZERO
void main() {
  Vector p = site_drawn();
  gl_FragColor = vec4(relaxed_site(Vector(0.0), p, level_at(from, p).COMPONENTS), REST);
}

#elif STEP == ELASTIC_RESTRICT
Vector fine_at(Vector p) {
#if IS_IMAGE
  return free_parts(level_at(from, p).COMPONENTS, straight_at(p));
#else
  return level_at(from, p).COMPONENTS;
#endif
}

Vector restricted_three(Vector before, Vector at, Vector after) {
  return Vector(restricted(before.x, at.x, after.x),
                restricted(before.y, at.y, after.y) AND_Z(restricted(before.z, at.z, after.z)));
}

Vector restricted_row(Vector p) {
#if HALVED_X == 0
  return fine_at(p);
#endif
  Vector apart = Vector(1.0, 0.0 AND_Z(0.0));
  return restricted_three(fine_at(p - apart), fine_at(p), fine_at(p + apart));
}

Vector restricted_plane(Vector p) {
#if HALVED_Y == 0
  return restricted_row(p);
#endif
  Vector apart = Vector(0.0, 1.0 AND_Z(0.0));
  return restricted_three(restricted_row(p - apart), restricted_row(p), restricted_row(p + apart));
}

void main() {
  Vector p = STRIDE * floor(site_drawn()) + Vector(1.5, 1.5 AND_Z(1.0)) - STRIDE; // the fine site of the coarse one
#if HDM_AXES > 2 && HALVED_Z == 0
  vec3 result = restricted_plane(p);
#elif HDM_AXES > 2
  vec3 apart = vec3(0.0, 0.0, 1.0);
  vec3 result = restricted_three(restricted_plane(p - apart), restricted_plane(p), restricted_plane(p + apart));
#else
  vec2 result = restricted_plane(p);
#endif
  gl_FragColor = vec4(result, REST);
}

#elif STEP == ELASTIC_INTERPOLATE || STEP == ELASTIC_CORRECT
void main() {
  Vector p = site_drawn();
  Vector site = floor(p) - 1.0;
  Vector coarse = floor(site / STRIDE);
#if STEP == ELASTIC_CORRECT
  Vector value = level_at(from, p).COMPONENTS;
#else
  Vector value = Vector(0.0);
#endif
  Vector result = corrected_site(value, site - STRIDE * coarse, coarse + Vector(1.5, 1.5 AND_Z(1.0)));
#if IS_IMAGE || HDM_AXES > 2
  Vector straight = straight_at(p);
  result = Vector(straight.x > 0.0 ? result.x : value.x,
                  straight.y > 0.0 ? result.y : value.y AND_Z(straight.z > 0.0 ? result.z : value.z));
#endif
  gl_FragColor = vec4(result, REST);
}

#elif STEP == ELASTIC_SOLVE
Vector with_column(Vector sum, vec2 at, float load) {
  Vector column = texture2DRect(matrices, at).COMPONENTS;
  return Vector(with_term(sum.x, column.x, load),
                with_term(sum.y, column.y, load) AND_Z(with_term(sum.z, column.z, load)));
}

void main() {
  Vector at = floor(site_drawn()) - 1.0;
  float row = at.y * extent.x + at.x + 0.5;
  float column = 0.5;
  Vector sum = Vector(0.0);
#if HDM_AXES > 2
  row += at.z * extent.x * extent.y;
  for (float z = 1.0; z < extent.z + 0.5; z += 1.0)
#endif
  {
    for (float y = 1.5; y < extent.y + 1.0; y += 1.0) {
      for (float x = 1.5; x < extent.x + 1.0; x += 1.0) {
        Vector load = level_at(from, Vector(x, y AND_Z(z))).COMPONENTS;
        sum = with_column(sum, vec2(row, column), load.x);
        sum = with_column(sum, vec2(row, column + 1.0), load.y);
        column += 2.0;
#if HDM_AXES > 2
        sum = with_column(sum, vec2(row, column), load.z);
        column += 1.0;
#endif
      }
    }
  }
  gl_FragColor = vec4(sum, REST);
}

#elif STEP == ELASTIC_ADVANCE
void main() {
  Vector value = level_at(from, site_drawn()).COMPONENTS;
  Vector way = level_at(second, site_drawn()).COMPONENTS;
  gl_FragColor = vec4(advanced(value.x, numbers.x, way.x),
                      advanced(value.y, numbers.x, way.y) AND_Z(advanced(value.z, numbers.x, way.z)), REST);
}

#else
// Of what is summed up, 0 beyond its border; p counts from 0.
real term_at(Vector p) {
#if STEP == ELASTIC_PRODUCTS
  Vector at = p + Vector(1.5, 1.5 AND_Z(1.0));
  Vector value = level_at(from, at).COMPONENTS;
  Vector other = level_at(second, at).COMPONENTS;
  real term = site_product(value.x, other.x, value.y, other.y);
#if HDM_AXES > 2
  term = with_term(term, value.z, other.z);
#endif
#else
  real term = level_at(from, p + Vector(0.5, 0.5 AND_Z(0.0))).x;
#endif
  return all(lessThan(p, extent)) ? term : 0.0;
}
real sum_of_square(Vector p) {
  return square_sum(term_at(p), term_at(p + Vector(1.0, 0.0 AND_Z(0.0))), term_at(p + Vector(0.0, 1.0 AND_Z(0.0))),
                    term_at(p + Vector(1.0, 1.0 AND_Z(0.0))));
}
// One level of the tree in a pass, and of a volume a loop over its squares: compilers without `precise` balance larger sums
// anew.
void main() {
  Vector p = 2.0 * floor(site_drawn());
#if HDM_AXES > 2
  real sum = 0.0;
  for (int square = 0; square < 2; ++square) {
    sum = corrected_by_one(sum, sum_of_square(p));
    p.z += 1.0;
  }
#else
  real sum = sum_of_square(p);
#endif
  gl_FragColor = vec4(sum);
}
#endif
