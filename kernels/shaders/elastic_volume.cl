// A step of the elastic energy of a volume (elastic_volume.h) as OpenCL C 1.2: numbers of a site are planes of one each.
// The host supplies STEP, HAS_LOAD, IS_IMAGE, BY_LIST, LANES, ROWS and COLUMNS.

#include "language.cl"

typedef struct Coefficients Coefficients;
typedef struct Stretch Stretch;
typedef struct Shear Shear;
typedef struct Divergence Divergence;
typedef struct Components Components;

// ElasticParameters.
typedef struct {
  int words[23];
} Parameters;

typedef struct {
  global const float* from;
  global const float* second;
  global float* to;
  global const float* moments;
  global const float* more; // moduli, numbers of matrices
  global const float* response;
  global const float* touched;
  global const float* matrices;
  global const float* inverse;
  Parameters p;
} Arrays;

#if defined(__clang__) && LANES == 1
#define SITES_SIDE_BY_SIDE _Pragma("clang loop vectorize(assume_safety) vectorize_width(16)")
#else
#define SITES_SIDE_BY_SIDE
#endif
#define ARRAYS const Arrays* a,
#define WITH_ARRAYS a,
#define COUNT(left) min(COLUMNS, width - (left))
#define WORD(i) a->p.words[i]
#define REAL_WORD(i) as_float(a->p.words[i])
#define PLANE ((size_t)WORD(15))
#define FROM(i, axis) a->from[(axis) * PLANE + (i)]
#define SECOND(i, axis) a->second[(axis) * PLANE + (i)]
#define TOUCHED(i, axis) a->touched[3 * (i) + (axis)]
#define RESPONSE(i, entry) a->response[(entry) * PLANE + (i)]
#define MODULUS(i) a->more[i]
#define MATRIX_NUMBER(i) a->more[PLANE + (i)]
#define MOMENT(i, number) a->moments[(number) * (PLANE - moments_from) + (i) - moments_from]
#define MATRIX(number, column, corner, axis) a->matrices[576 * (size_t)(number) + 24 * (column) + 3 * (corner) + (axis)]
#define INVERSE(column, sites, site, axis) a->inverse[3 * ((column) * (sites) + (site)) + (axis)]
// Arrays of sums have one plane.
#define STORE(i, x, y, z) \
  a->to[i] = x, STEP < ELASTIC_PRODUCTS ? (a->to[PLANE + (i)] = y, a->to[2 * PLANE + (i)] = z) : 0.0f
#define int_of(value) (int)(value)

#include "elastic_volume.h"

kernel void elastic_step(global const float* restrict from, global const float* restrict second, global float* restrict to,
                 global const float* restrict moments, global const float* restrict response,
                 global const float* restrict touched, global const float* restrict more,
                 global const float* restrict matrices, global const float* restrict inverse, Parameters p) {
  Arrays arrays = {from, second, to, moments, more, response, touched, matrices, inverse, p};
  do_item(&arrays, get_group_id(0) * LANES + get_local_id(0));
}
