// The forces of tissues with laws of large strains (specification/laws), for every kind of GLSL from 4.30 on
// and for OpenCL C, in three steps over layers of cells: what each cell does to its corners, what all cells
// around do to a site, and which cell has kept least of its volume. An image is a layer of cells whose two
// faces move alike; its rows lie where a volume has planes, and y is 0. The includer supplies the macros of
// the specification and
//
// - HDM_AXES: 2, an image, or 3, a volume. STEP: law_steps.h. FIBRES: not 0 where tissues have some.
// - COLUMNS: the cells or sites of a row that a work item has. SIDE_BY_SIDE: stands before loops over these.
// - ARRAYS, WITH_ARRAYS: parameter and argument of functions that use what follows, with a comma.
// - TOLD(i), REAL_TOLD(i): word i of LawParameters.
// - GET_DISPLACEMENT(components, i): assigns what the field has at element i of its array.
// - TISSUE(site, number): the modulus of a site, and the parameter of its law.
// - FIBRE(site, number): x, y, z and compression of a fibre.
// - SITE_BITS(site): law_steps.h.
// - GET_FORCE(components, cell, corner), STORE_FORCE(cell, corner, components): what cells do.
// - STORE_SITE(i, components): stores into element i of the array of a field.
// - SHARE(cell), STORE_SHARE(cell, bits): what cells have kept, as bits.
// - BITS_OF(real), REAL_OF(bits), STORE_LEAST(item, bits, site).

#define HDM_BOXES false
#include "elastic/volume.inc"
#include "law_steps.h"
// In this order: each needs what stands before it.
#include "laws/reciprocal.inc"
#include "laws/strain.inc"
// The law's own text.
#include "law.inc"
// What comes after it.
#include "laws/cell.inc"
#include "laws/fibres.inc"
#include "laws/stress.inc"

#ifndef HDM_UNROLLED
#define HDM_UNROLLED
#endif
#define EACH_AXIS HDM_UNROLLED for (int axis = 0; axis < HDM_AXES; ++axis)
#define EACH_CORNER HDM_UNROLLED for (int corner = 0; corner < 8; ++corner)

// Corners of a cell are numbered with x in the lowest bit and z in the highest; so far they are from the
// first.
#define ALONG_X(corner) ((corner)&1)
#define ALONG_Y(corner) (HDM_AXES == 3 ? (corner) >> 1 & 1 : 0)
#define ALONG_Z(corner) (HDM_AXES == 3 ? (corner) >> 2 : (corner) >> 1 & 1)

// The field has so many sites along each axis; then where they lie in its array.
#define width TOLD(8)
#define height TOLD(9)
#define depth TOLD(10)
#define ELEMENT(x, y, z) (TOLD(11) + (z)*TOLD(13) + (y)*TOLD(12) + (x))
#define SITE(x, y, z) (((z)*height + (y)) * width + (x))
// Cells along x and y, and those layers of them whose forces are kept.
#define cells_across (width - 1)
#define cells_down max(height - 1, 1)
#define first_layer TOLD(14)
#define layer_count TOLD(15)
#define first_layer_of_sites TOLD(16)
#define no_share 0x7F800000 // the bits of infinity

struct Components {
  real along[HDM_AXES];
};
struct Cell {
  int x, y, z;
};

HDM_FUNCTION Components components_of(real x, real y, real z) {
  Components c;
  c.along[0] = x;
  c.along[1] = y;
#if HDM_AXES == 3
  c.along[2] = z;
#endif
  return c;
}

// Returns where cell or site `number` is, in layers from `layer` on that have `down` rows of `across` each.
HDM_FUNCTION Cell place_of(int number, int across, int down, int layer) {
  int line = number / across;
  int slab = line / down;
  Cell place;
  place.x = number - line * across;
  place.y = line - slab * down;
  place.z = layer + slab;
  return place;
}
#define STRIPS(across) (((across) + COLUMNS - 1) / COLUMNS)

HDM_FUNCTION Coefficients coefficients_at(real c0, real c1, real c2, real c3, real c4, real c5, real c6,
                                          real c7) {
  CellCorners u;
  u.c000 = c0, u.c100 = c1, u.c010 = c2, u.c110 = c3;
  u.c001 = c4, u.c101 = c5, u.c011 = c6, u.c111 = c7;
  return coefficients_of(u);
}
#define COEFFICIENTS(axis)                                                                                   \
  coefficients_at(u[0].along[axis], u[1].along[axis], u[2].along[axis], u[3].along[axis], u[4].along[axis],  \
                  u[5].along[axis], u[6].along[axis], u[7].along[axis])

HDM_FUNCTION int number_of(ARRAYS int x, int y, int z) {
  return ((z - first_layer) * cells_down + y) * cells_across + x;
}

HDM_FUNCTION void do_cell(ARRAYS Cell cell) {
  int number = number_of(WITH_ARRAYS cell.x, cell.y, cell.z);
  int element = ELEMENT(cell.x, cell.y, cell.z);
  int site = SITE(cell.x, cell.y, cell.z);
  Components u[8];
  real modulus[8];
  real parameter[8];
  EACH_CORNER {
    GET_DISPLACEMENT(u[corner],
                     element + ALONG_X(corner) + ALONG_Y(corner) * TOLD(12) + ALONG_Z(corner) * TOLD(13))
    int at = site + SITE(ALONG_X(corner), ALONG_Y(corner), ALONG_Z(corner));
    modulus[corner] = TISSUE(at, 0);
    parameter[corner] = TISSUE(at, 1);
  }
  real softest = modulus[0];
  EACH_CORNER {
    softest = lesser(softest, modulus[corner]);
  }
  Sides sides;
  sides.x = REAL_TOLD(0), sides.y = REAL_TOLD(1), sides.z = REAL_TOLD(2);
  Material material;
  material.mu = REAL_TOLD(4), material.lame = REAL_TOLD(5), material.half_modulus = REAL_TOLD(6);
  material.least_modulus = REAL_TOLD(7);
#if HDM_AXES == 3
  Coefficients along_z = COEFFICIENTS(2);
#else
  real none = HDM_NUMBER(0);
  Coefficients along_z = coefficients_at(none, none, none, none, none, none, none, none);
#endif
  Gradients h = gradients_of(slopes_at_points(COEFFICIENTS(0), sides),
                             slopes_at_points(COEFFICIENTS(1), sides), slopes_at_points(along_z, sides));
  Stresses s;
  real least = REAL_OF(no_share);
#define POINT(corner, point)                                                                                 \
  {                                                                                                          \
    Tissue tissue = tissue_of(material, modulus[corner], parameter[corner], softest);                        \
    s.point = stress_of(tissue, h.point);                                                                    \
    if (FIBRES != 0) {                                                                                       \
      int at = site + SITE(ALONG_X(corner), ALONG_Y(corner), ALONG_Z(corner));                               \
      Fibre fibre = fibre_of(material, modulus[corner], FIBRE(at, 0), FIBRE(at, 1), FIBRE(at, 2),            \
                             FIBRE(at, 3), softest);                                                         \
      s.point = with_fibre(s.point, fibre, h.point);                                                         \
    }                                                                                                        \
    least = lesser(least, share_left(tissue, h.point));                                                      \
  }
  POINT(0, p000)
  POINT(1, p100)
  POINT(2, p010)
  POINT(3, p110)
  POINT(4, p001)
  POINT(5, p101)
  POINT(6, p011)
  POINT(7, p111)
  CellTension tension = tension_of_stresses(s, sides);
  CellCorners x = forces_of(tension.x);
  CellCorners y = forces_of(tension.y);
  CellCorners z = forces_of(tension.z);
#define FORCE(corner, at) STORE_FORCE(number, corner, components_of(x.at, y.at, z.at))
  FORCE(0, c000)
  FORCE(1, c100)
  FORCE(2, c010)
  FORCE(3, c110)
  FORCE(4, c001)
  FORCE(5, c101)
  FORCE(6, c011)
  FORCE(7, c111)
  bool counts = (SITE_BITS(site) >> LAW_COUNTS & 1) != 0;
  STORE_SHARE(number, counts ? BITS_OF(least) : no_share)
}

HDM_FUNCTION real plus(real before, real force) {
  HDM_PRECISE real sum = before + force;
  return sum;
}

// Cells add what they do in the order of kernels/data/elastic/law_forces.cpp: row by row of cells, by the
// four rows of sites around each, a cell on the right before that on the left.
HDM_FUNCTION void do_site(ARRAYS Cell at) {
  Components sum = components_of(HDM_NUMBER(0), HDM_NUMBER(0), HDM_NUMBER(0));
  HDM_UNROLLED
  for (int i = 0; i < 8; ++i) {
    int row = HDM_AXES == 3 ? 3 - (i >> 1) : 1 - (i >> 2) + (i & 2);
    int corner = 2 * row + (i & 1);
    int x = at.x - ALONG_X(corner);
    int y = at.y - ALONG_Y(corner);
    int z = at.z - ALONG_Z(corner);
    bool is_there = x >= 0 && y >= 0 && z >= 0 && x < cells_across && y < cells_down && z < depth - 1;
    int cell = is_there ? number_of(WITH_ARRAYS x, y, z) : 0;
    Components force;
    GET_FORCE(force, cell, corner)
    EACH_AXIS {
      sum.along[axis] = is_there ? plus(sum.along[axis], force.along[axis]) : sum.along[axis];
    }
  }
  int bits = SITE_BITS(SITE(at.x, at.y, at.z));
  real none = HDM_NUMBER(0);
  EACH_AXIS {
    sum.along[axis] = (bits >> axis & 1) != 0 ? none : sum.along[axis];
  }
  STORE_SITE(ELEMENT(at.x, at.y, at.z), sum)
}

// The first of the least among cells item, item + items, and so on.
HDM_FUNCTION void do_least(ARRAYS int item, int items) {
  int bits = no_share;
  int first = 0;
  for (int cell = item; cell < cells_across * cells_down * layer_count; cell += items) {
    int share = SHARE(cell);
    bool is_less = REAL_OF(share) < REAL_OF(bits);
    bits = is_less ? share : bits;
    first = is_less ? cell : first;
  }
  Cell at = place_of(first, cells_across, cells_down, first_layer);
  STORE_LEAST(item, bits, SITE(at.x, at.y, at.z))
}

// All that a dispatch does, as work item `item` of so many.
HDM_FUNCTION void do_share(ARRAYS int item, int items) {
  if (STEP == LAW_LEAST) {
    do_least(WITH_ARRAYS item, items);
    return;
  }
  bool has_cells = STEP == LAW_CELLS;
  int across = has_cells ? cells_across : width;
  int down = has_cells ? cells_down : height;
  int layers = has_cells ? layer_count : TOLD(17);
  if (item >= STRIPS(across) * down * layers) {
    return;
  }
  Cell at = place_of(item, STRIPS(across), down, has_cells ? first_layer : first_layer_of_sites);
  int left = COLUMNS * at.x;
  int count = min(COLUMNS, across - left);
  if (has_cells) {
    SIDE_BY_SIDE
    for (int i = 0; i < count; ++i) {
      at.x = left + i;
      do_cell(WITH_ARRAYS at);
    }
  } else {
    SIDE_BY_SIDE
    for (int i = 0; i < count; ++i) {
      at.x = left + i;
      do_site(WITH_ARRAYS at);
    }
  }
}
