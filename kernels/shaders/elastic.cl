// Steps of the elastic energy (elastic_sites.h) as OpenCL C 1.2: numbers of a site are planes of one each. The host supplies
// HDM_AXES, STEP, HAS_LOAD, IS_IMAGE, BY_LIST, LANES, ROWS, COLUMNS, BOXES, HALVED and TOGETHER.

#include "language.cl"
#include "elastic_steps.h"

typedef struct Coefficients Coefficients;
typedef struct Stretch Stretch;
typedef struct Shear Shear;
typedef struct Divergence Divergence;
typedef struct Slopes Slopes;
typedef struct Components Components;
typedef struct CellNumbers CellNumbers;
typedef struct CellComponents CellComponents;
typedef struct Place Place;
typedef struct Work Work;
typedef struct Sum Sum;
typedef struct Strip Strip;

typedef struct {
  int words[32];
} Told;

typedef struct {
  __global float* from; // the three fields of a level where several steps are done
  __global float* second;
  __global float* third;
  __global float* to;
  __global const float* moments;
  __global const float* response;
  __global const float* matrices;
  __global const float* inverse;
  __global const int* touched;
  Told told;
} Arrays;

// One item on a CPU has many columns, which become SIMD. On a GPU an item has few: loops over all of them, whose number is
// a constant, are unrolled, and arrays of columns are registers and no memory.
#if LANES > 1
#define SITES_SIDE_BY_SIDE HDM_UNROLLED
#define COUNT(left, columns) (columns)
#define IS_THERE(column) ((column) < MY(place).width)
#else
#ifdef __clang__
#define SITES_SIDE_BY_SIDE _Pragma("clang loop vectorize(assume_safety) vectorize_width(16)")
#else
#define SITES_SIDE_BY_SIDE
#endif
#define COUNT(left, columns) (MY(place).width - (left) < (columns) ? MY(place).width - (left) : (columns))
#define IS_THERE(column) true
#endif
#define ONLY_WHERE(condition) if (condition)
#define ARRAYS const Arrays *a, Work *work,
#define WITH_ARRAYS a, work,
#define WORK_OF_ITEM
#define MY(name) work->name
#define DIVIDED(number, by) ((number) / (by))
#define SITE_COLUMNS COLUMNS
#define SITE_ROWS ROWS
#define TOLD(i) a->told.words[i]
#if LANES > 1
#define SLOT(number) slot_of(a, number)
#define CODE_TOLD(number) code_told(a, number)
#else
#define SLOT(number) ((number) == 0 ? a->from : (number) == 1 ? a->second : a->third)
#define CODE_TOLD(number) TOLD(12 + (number))
#endif
#define REAL_TOLD(i) as_float(TOLD(i))
#define PLANE ((size_t)TOLD(3))
#define FIELD(single, slot) (TOGETHER != 0 ? SLOT(work->slot) + base : a->single)
// Arrays of sums have one plane.
#define GET_FROM(c, i)                                                                         \
  HDM_UNROLLED                                                                                 \
  for (int axis = 0; axis < (STEP == ELASTIC_SQUARES ? 1 : HDM_AXES); ++axis) {                \
    c.along[axis] = FIELD(from, from_slot)[axis * PLANE + (i)];                                \
  }
#define GET_SECOND(c, i)                                                                       \
  EACH_AXIS {                                                                                  \
    c.along[axis] = FIELD(second, second_slot)[axis * PLANE + (i)];                            \
  }
#define RESPONSE(i, entry) a->response[(entry) * PLANE + base + (i)]
#define MOMENT(i, number) a->moments[(number) * (PLANE - moments_from) + base + (i) - moments_from]
// Blocks are filled up to fours.
#define MATRIX(block, number) a->matrices[(HDM_AXES * HDM_AXES + 3) / 4 * 4 * (size_t)(block) + (number)]
#define GET_INVERSE(c, i)                                                                      \
  EACH_AXIS {                                                                                  \
    c.along[axis] = a->inverse[HDM_AXES * (i) + axis];                                         \
  }
#define TOUCHED(i) a->touched[i]
#define STORE(i, components)                                                                                               \
  HDM_UNROLLED                                                                                                             \
  for (int axis = 0; axis < (STEP < ELASTIC_PRODUCTS ? HDM_AXES : 1); ++axis) {                                            \
    FIELD(to, stored_slot)[axis * PLANE + (i)] = components.along[axis];                                                   \
  }
#define WAIT_FOR_ALL barrier(CLK_GLOBAL_MEM_FENCE)

// A GPU would put all that a kernel is told into memory, if an index or an address were known at run time only.
#if LANES > 1
HDM_FUNCTION __global float* slot_of(const Arrays* a, int number) {
  __global float* from = a->from;
  __global float* second = a->second;
  __global float* third = a->third;
  return number == 0 ? from : number == 1 ? second : third;
}
HDM_FUNCTION int code_told(const Arrays* a, int number) {
  int code = 0;
  HDM_UNROLLED
  for (int i = 0; i < ELASTIC_TOGETHER_STEPS; ++i) {
    int told = TOLD(12 + i);
    code = i == number ? told : code;
  }
  return code;
}
#endif

#include "elastic_sites.h"

kernel __attribute__((reqd_work_group_size(LANES, 1, 1))) void elastic_step(
    __global float* from, __global float* second, __global float* third, __global float* to,
    __global const float* restrict moments, __global const float* restrict response,
    __global const float* restrict matrices, __global const float* restrict inverse, __global const int* restrict touched,
    Told told) {
  Arrays arrays = {from, second, third, to, moments, response, matrices, inverse, touched, told};
  Work work;
  do_share(&arrays, &work, get_global_id(0), get_global_size(0));
}
