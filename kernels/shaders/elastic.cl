// Steps of the elastic energy (elastic_sites.h) as OpenCL C 1.2: numbers of a site are planes of one each. The host supplies
// HDM_AXES, STEP, HAS_LOAD, IS_IMAGE, BY_LIST, LANES, ROWS, COLUMNS and TOGETHER.

#include "language.cl"

typedef struct Coefficients Coefficients;
typedef struct Stretch Stretch;
typedef struct Shear Shear;
typedef struct Divergence Divergence;
typedef struct Components Components;
typedef struct CellNumbers CellNumbers;
typedef struct CellComponents CellComponents;
typedef struct Place Place;
typedef struct Work Work;
typedef struct Sum Sum;

typedef struct {
  int words[32];
} Told;

typedef struct {
  global float* from; // the three fields of a level where several steps are done
  global float* second;
  global float* third;
  global float* to;
  global const float* moments;
  global const float* response;
  global const float* matrices;
  global const float* inverse;
  global const int* touched;
  Told told;
} Arrays;

#if defined(__clang__) && LANES == 1
#define SITES_SIDE_BY_SIDE _Pragma("clang loop vectorize(assume_safety) vectorize_width(16)")
#else
#define SITES_SIDE_BY_SIDE
#endif
#define ONLY_IF(condition) if (condition)
#define ARRAYS const Arrays *a, Work *work,
#define WITH_ARRAYS a, work,
#define WORK_OF_ITEM
#define MY(name) work->name
#define COUNT(left) min(COLUMNS, MY(place).width - (left))
#define TOLD(i) a->told.words[i]
#define REAL_TOLD(i) as_float(TOLD(i))
#define PLANE ((size_t)TOLD(3))
#define SLOT(number) ((number) == 0 ? a->from : (number) == 1 ? a->second : a->third)
#define FIELD(single, slot) (TOGETHER != 0 ? SLOT(work->slot) + base : a->single)
#define FROM(i, axis) FIELD(from, from_slot)[(axis) * PLANE + (i)]
#define SECOND(i, axis) FIELD(second, second_slot)[(axis) * PLANE + (i)]
#define RESPONSE(i, entry) a->response[(entry) * PLANE + base + (i)]
#define MOMENT(i, number) a->moments[(number) * (PLANE - moments_from) + base + (i) - moments_from]
#define MATRIX(i) a->matrices[i]
#define INVERSE(i) a->inverse[i]
#define TOUCHED(i) a->touched[i]
// Arrays of sums have one plane.
#define STORE(i, components) store(a, work, i, components)
#define WAIT_FOR_ALL barrier(CLK_GLOBAL_MEM_FENCE)

static inline __attribute__((always_inline)) void store(const Arrays* a, Work* work, int at, Components value);

#include "elastic_sites.h"

HDM_FUNCTION void store(const Arrays* a, Work* work, int at, Components value) {
  EACH_AXIS {
    if (axis == 0 || MY(step) < ELASTIC_PRODUCTS) {
      FIELD(to, stored_slot)[axis * PLANE + at] = value.along[axis];
    }
  }
}

kernel void elastic_step(global float* from, global float* second, global float* third, global float* to,
                         global const float* restrict moments, global const float* restrict response,
                         global const float* restrict matrices, global const float* restrict inverse,
                         global const int* restrict touched, Told told) {
  Arrays arrays = {from, second, third, to, moments, response, matrices, inverse, touched, told};
  Work work;
  do_share(&arrays, &work, get_global_id(0), get_global_size(0));
}
