// The forces of tissues with laws of large strains (laws.h) as OpenCL C 1.2: numbers of a site are planes of one each. The host
// supplies HDM_AXES, STEP, FIBRES, LANES and COLUMNS.

#include "language.cl"

typedef struct Coefficients Coefficients;
typedef struct Stretch Stretch;
typedef struct Shear Shear;
typedef struct Divergence Divergence;
typedef struct Slopes Slopes;
typedef struct Gradient Gradient;
typedef struct Gradients Gradients;
typedef struct Stress Stress;
typedef struct Stresses Stresses;
typedef struct Material Material;
typedef struct Tissue Tissue;
typedef struct Fibre Fibre;
typedef struct Sides Sides;
typedef struct SlopeAtPoints SlopeAtPoints;
typedef struct SlopesAtPoints SlopesAtPoints;
typedef struct AtPoints AtPoints;
typedef struct PointSums PointSums;
typedef struct Components Components;
typedef struct Cell Cell;
#define HDM_STRUCT(name) typedef struct name name;
#define HDM_BITS_LESS(number, x) as_float((number)-as_int(x))

typedef struct {
  int words[32];
} Told;

typedef struct {
  __global float* to;
  __global const int* site_bits;
  __global int* shares;
  __global int* least_of_items;
  __global const float* displacement;
  __global const float* tissues;
  __global const float* forces;
  __global const float* fibres;
  Told told;
} Arrays;

#ifdef __clang__
#define SIDE_BY_SIDE _Pragma("clang loop vectorize(assume_safety)")
#else
#define SIDE_BY_SIDE
#endif
#define ARRAYS const Arrays *a,
#define WITH_ARRAYS a,
#define TOLD(i) a->told.words[i]
#define REAL_TOLD(i) as_float(TOLD(i))
#define BITS_OF(value) as_int(value)
#define REAL_OF(bits) as_float(bits)
#define PLANE ((size_t)TOLD(3))   // of the field
#define CELLS ((size_t)TOLD(18))  // whose forces there is room for
#define SITE_NUMBER(site, number) (TOLD(21) + (number) * (size_t)TOLD(20) + (site))
#define GET_DISPLACEMENT(c, i)                                  \
  EACH_AXIS {                                                   \
    c.along[axis] = a->displacement[axis * PLANE + (i)];        \
  }
#define TISSUE(site, number) a->tissues[SITE_NUMBER(site, number)]
#define FIBRE(site, number) a->fibres[SITE_NUMBER(site, number)]
#define SITE_BITS(site) a->site_bits[site]
#define FORCE_AT(cell, corner) (((corner) * HDM_AXES + axis) * CELLS + (cell))
#define GET_FORCE(c, cell, corner)                              \
  EACH_AXIS {                                                   \
    c.along[axis] = a->forces[FORCE_AT(cell, corner)];          \
  }
#define STORE_FORCE(cell, corner, components)                   \
  {                                                             \
    Components c = components;                                  \
    EACH_AXIS {                                                 \
      a->to[FORCE_AT(cell, corner)] = c.along[axis];            \
    }                                                           \
  }
#define STORE_SITE(i, components)                               \
  EACH_AXIS {                                                   \
    a->to[axis * PLANE + (i)] = components.along[axis];         \
  }
#define SHARE(cell) a->shares[cell]
#define STORE_SHARE(cell, bits) a->shares[cell] = bits;
#define STORE_LEAST(item, bits, site)                           \
  a->least_of_items[2 * (TOLD(19) + (item))] = bits;            \
  a->least_of_items[2 * (TOLD(19) + (item)) + 1] = site;

#include "laws.h"

kernel __attribute__((reqd_work_group_size(LANES, 1, 1))) void law_step(
    __global float* to, __global const int* restrict site_bits, __global int* shares, __global int* least_of_items,
    __global const float* restrict displacement, __global const float* restrict tissues, __global const float* restrict forces,
    __global const float* restrict fibres, Told told) {
  Arrays arrays = {to, site_bits, shares, least_of_items, displacement, tissues, forces, fibres, told};
  do_share(&arrays, (int)get_global_id(0), (int)get_global_size(0));
}
