// A step of the elastic energy of a volume, as every kind of GLSL from 4.30 on and as OpenCL C: a work item
// goes along z through ROWS sites, of COLUMNS columns side by side, so that relax and residual fetch each
// plane once and keep what a cell does to its far corners. Or, of relax and residual, one site of a list,
// those beside masked cells. Compiled after the macros of the specification; the includer supplies
//
//   STEP, HAS_LOAD, IS_IMAGE, BY_LIST  ElasticKernel, numbers; IS_IMAGE of relax and residual: cells are
//   those of eight moduli COLUMNS, ROWS COUNT(left)                        of the columns, how many are
//   computed: may be more than there are ARRAYS, WITH_ARRAYS                parameter and argument of the
//   functions that use what follows, with a comma WORD(i), REAL_WORD(i)              of ElasticParameters
//   FROM(i, axis), SECOND(i, axis), TOUCHED(i, axis), RESPONSE(i, entry), MODULUS(i), MATRIX_NUMBER(i),
//   MOMENT(i, number), MATRIX(number, column, corner, axis), INVERSE(column, sites, site, axis) STORE(i, x,
//   y, z) SITES_SIDE_BY_SIDE                 stands before loops over columns

#include "elastic/site.inc"
#include "elastic/volume.inc"
#include "elastic_steps.h"

#ifndef HDM_UNROLLED
#define HDM_UNROLLED
#endif
#define EACH_AXIS HDM_UNROLLED for (int axis = 0; axis < 3; ++axis)

#define width WORD(0)
#define height WORD(1)
#define first WORD(2)
#define pitch WORD(3)
#define from_first WORD(4)
#define from_pitch WORD(5)
#define from_width WORD(6)
#define from_height WORD(7)
#define second_first WORD(8)
#define second_pitch WORD(9)
#define listed_first WORD(10)
#define listed WORD(11)
#define factor REAL_WORD(14)
#define depth WORD(16)
#define layer WORD(17)
#define from_depth WORD(18)
#define from_layer WORD(19)
#define second_layer WORD(20)
#define lame REAL_WORD(21)
#define moments_from WORD(22) // sites before those that have moments

// Of a site, along x, y and z.
struct Components {
  real along[3];
};

// Of a cell that has moments of its own.
HDM_FUNCTION CellMoments moments_at(ARRAYS int i) {
  CellMoments c;
  c.m = MOMENT(i, 0), c.r = MOMENT(i, 1), c.s = MOMENT(i, 2), c.t = MOMENT(i, 3);
  c.rr = MOMENT(i, 4), c.ss = MOMENT(i, 5), c.tt = MOMENT(i, 6);
  c.rs = MOMENT(i, 7), c.rt = MOMENT(i, 8), c.st = MOMENT(i, 9);
  c.rrs = MOMENT(i, 10), c.rrt = MOMENT(i, 11), c.rss = MOMENT(i, 12);
  c.sst = MOMENT(i, 13), c.rtt = MOMENT(i, 14), c.stt = MOMENT(i, 15);
  c.rst = MOMENT(i, 16), c.rrst = MOMENT(i, 17), c.rsst = MOMENT(i, 18), c.rstt = MOMENT(i, 19);
  c.rrss = MOMENT(i, 20), c.rrtt = MOMENT(i, 21), c.sstt = MOMENT(i, 22);
  return c;
}

// What lies at the corners of cell i, of one component or of another array. Of moduli those that are not
// `there` are 0.
#define CORNERS(to, VALUE, i, there)                                                                         \
  to.c000 = there ? VALUE(i) : none, to.c100 = there ? VALUE(i + 1) : none;                                  \
  to.c010 = there ? VALUE(i + from_pitch) : none, to.c110 = there ? VALUE(i + from_pitch + 1) : none;        \
  to.c001 = there ? VALUE(i + from_layer) : none, to.c101 = there ? VALUE(i + from_layer + 1) : none;        \
  to.c011 = there ? VALUE(i + from_layer + from_pitch) : none,                                               \
  to.c111 = there ? VALUE(i + from_layer + from_pitch + 1) : none

// Cells of the ring around a level have no stiffness.
HDM_FUNCTION bool is_cell(ARRAYS int x, int y, int z) {
  return x >= 0 && y >= 0 && z >= 0 && x < from_width - 1 && y < from_height - 1 && z < from_depth - 1;
}

// The last thing that is done to a site.
HDM_FUNCTION void finish_site(ARRAYS int at, int to, Components force) {
  Components value = force;
  EACH_AXIS {
    if (HAS_LOAD != 0) {
      force.along[axis] = corrected_by_one(SECOND(at, axis), force.along[axis]);
    }
  }
  real xx = RESPONSE(at, 0), xy = RESPONSE(at, 1), xz = RESPONSE(at, 2);
  real yy = RESPONSE(at, 3), yz = RESPONSE(at, 4), zz = RESPONSE(at, 5);
  real x = force.along[0], y = force.along[1], z = force.along[2];
  if (STEP == ELASTIC_RESIDUAL) {
    STORE(to, free_part(x, xx), free_part(y, yy), free_part(z, zz));
  } else {
    EACH_AXIS {
      value.along[axis] = STEP == ELASTIC_RELAX ? FROM(at, axis) : HDM_NUMBER(0);
    }
    STORE(to, relaxed_in_volume(value.along[0], xx, x, xy, y, xz, z),
          relaxed_in_volume(value.along[1], yy, y, xy, x, yz, z),
          relaxed_in_volume(value.along[2], zz, z, xz, x, yz, y));
  }
}

// What a plane has around the columns: rows y - 1 ... y + 1, columns left - 1 ... left + COLUMNS.
#define FETCH_PLANE(u, e, at)                                                                                \
  for (int row = 0; row < 3; ++row) {                                                                        \
    SITES_SIDE_BY_SIDE                                                                                       \
    for (int i = 0; i < COUNT(left) + 2; ++i) {                                                              \
      EACH_AXIS {                                                                                            \
        u[3 * row + axis][i] = FROM(at + (row - 1) * from_pitch - 1 + i, axis);                              \
      }                                                                                                      \
      if (IS_IMAGE != 0) {                                                                                   \
        e[row][i] = MODULUS(at + (row - 1) * from_pitch - 1 + i);                                            \
      }                                                                                                      \
    }                                                                                                        \
  }
#define CORNERS_OF(to, here, next, r, next_r)                                                                \
  to.c000 = here[r][i], to.c100 = here[r][i + 1];                                                            \
  to.c010 = here[next_r][i], to.c110 = here[next_r][i + 1];                                                  \
  to.c001 = next[r][i], to.c101 = next[r][i + 1];                                                            \
  to.c011 = next[next_r][i], to.c111 = next[next_r][i + 1]
// Of cell i on the sites of row y: those west and east of it, on both planes.
#define KEEP_FORCES(axis, tension)                                                                           \
  force = forces_of(tension);                                                                                \
  near[axis][2 * row][i] = row == 0 ? force.c110 : force.c100;                                               \
  near[axis][2 * row + 1][i] = row == 0 ? force.c010 : force.c000;                                           \
  far[axis][2 * row][i] = row == 0 ? force.c111 : force.c101;                                                \
  far[axis][2 * row + 1][i] = row == 0 ? force.c011 : force.c001
#define SLAB_SUM(of) square_sum(of[axis][0][i], of[axis][1][i + 1], of[axis][2][i], of[axis][3][i + 1])

HDM_FUNCTION void sweep_columns(ARRAYS int left, int y, int begin, int end) {
  real here[9][COLUMNS + 2],
      next[9][COLUMNS + 2]; // displacements on a plane and the next: row by row x, y, z
  real modulus_here[3][COLUMNS + 2], modulus_next[3][COLUMNS + 2];
  real near[3][4][COLUMNS + 1], far[3][4][COLUMNS + 1]; // forces on both; cell i is to the west of column i
  real above[3][COLUMNS];                               // on a plane's sites, of the cells before it
  int at = from_first + (begin - 1) * from_layer + y * from_pitch + left;
  FETCH_PLANE(here, modulus_here, at)
  for (int z = begin - 1; z < end; ++z) {
    FETCH_PLANE(next, modulus_next, at + from_layer)
    HDM_UNROLLED
    for (int row = 0; row < 2; ++row) {
      SITES_SIDE_BY_SIDE
      for (int i = 0; i < COUNT(left) + 1; ++i) {
        CellCorners u, v, w, e, force;
        CORNERS_OF(u, here, next, 3 * row, 3 * row + 3);
        CORNERS_OF(v, here, next, 3 * row + 1, 3 * row + 4);
        CORNERS_OF(w, here, next, 3 * row + 2, 3 * row + 5);
        CellMoments moments_of_cell;
        if (IS_IMAGE != 0) {
          CORNERS_OF(e, modulus_here, modulus_next, row, row + 1);
          bool there = is_cell(WITH_ARRAYS left - 1 + i, y - 1 + row, z);
          real none = HDM_NUMBER(0);
          e.c000 = there ? e.c000 : none, e.c100 = there ? e.c100 : none;
          e.c010 = there ? e.c010 : none, e.c110 = there ? e.c110 : none;
          e.c001 = there ? e.c001 : none, e.c101 = there ? e.c101 : none;
          e.c011 = there ? e.c011 : none, e.c111 = there ? e.c111 : none;
          moments_of_cell = image_cell(e);
        } else {
          moments_of_cell = moments_at(WITH_ARRAYS at + (row - 1) * from_pitch - 1 + i);
        }
        CellTension tension =
            cell_tension(moments_of_cell, coefficients_of(u), coefficients_of(v), coefficients_of(w), lame);
        KEEP_FORCES(0, tension.x);
        KEEP_FORCES(1, tension.y);
        KEEP_FORCES(2, tension.z);
      }
    }
    SITES_SIDE_BY_SIDE
    for (int i = 0; i < COUNT(left); ++i) {
      Components sum;
      EACH_AXIS {
        sum.along[axis] = corrected_by_one(above[axis][i], SLAB_SUM(near));
        above[axis][i] = SLAB_SUM(far);
      }
      if (z >= begin && left + i < width) {
        finish_site(WITH_ARRAYS at + i, first + z * layer + y * pitch + left + i, sum);
      }
    }
    for (int row = 0; row < 3; ++row) {
      SITES_SIDE_BY_SIDE
      for (int i = 0; i < COUNT(left) + 2; ++i) {
        EACH_AXIS {
          here[3 * row + axis][i] = next[3 * row + axis][i];
        }
        modulus_here[row][i] = modulus_next[row][i];
      }
    }
    at += from_layer;
  }
}

HDM_FUNCTION real at_corner(CellCorners c, int corner) {
  real near = corner < 2 ? (corner == 0 ? c.c000 : c.c100) : (corner == 2 ? c.c010 : c.c110);
  real far = corner < 6 ? (corner == 4 ? c.c001 : c.c101) : (corner == 6 ? c.c011 : c.c111);
  return corner < 4 ? near : far;
}

// What cell i does to its corner, x in the lowest bit.
HDM_FUNCTION Components force_of_cell(ARRAYS int i, bool there, int corner) {
  real none = HDM_NUMBER(0);
  int number = int_of(MATRIX_NUMBER(i)) - 1;
  Components force;
  if (number >= 0) {
    EACH_AXIS {
      force.along[axis] = none;
    }
    for (int of = 0; of < 8; ++of) {
      int site = i + (of & 1) + (of >> 1 & 1) * from_pitch + (of >> 2) * from_layer;
      for (int component = 0; component < 3; ++component) {
        real moved = FROM(site, component);
        EACH_AXIS {
          force.along[axis] =
              masked_force(force.along[axis], MATRIX(number, 3 * of + component, corner, axis), moved);
        }
      }
    }
    return force;
  }
  CellCorners u, v, w, e;
  CellMoments moments_of_cell;
#define VALUE(i) FROM(i, 0)
  CORNERS(u, VALUE, i, true);
#undef VALUE
#define VALUE(i) FROM(i, 1)
  CORNERS(v, VALUE, i, true);
#undef VALUE
#define VALUE(i) FROM(i, 2)
  CORNERS(w, VALUE, i, true);
  if (IS_IMAGE != 0) {
    CORNERS(e, MODULUS, i, there);
    moments_of_cell = image_cell(e);
  } else {
    moments_of_cell = moments_at(WITH_ARRAYS i);
  }
  CellTension tension =
      cell_tension(moments_of_cell, coefficients_of(u), coefficients_of(v), coefficients_of(w), lame);
  force.along[0] = at_corner(forces_of(tension.x), corner);
  force.along[1] = at_corner(forces_of(tension.y), corner);
  force.along[2] = at_corner(forces_of(tension.z), corner);
  return force;
}

// A site beside masked cells: cells along x, then y, then z.
HDM_FUNCTION void sweep_listed(ARRAYS int x, int y, int z) {
  int at = from_first + z * from_layer + y * from_pitch + x;
  Components line, slab, sum;
  for (int cell = 7; cell >= 0; --cell) { // by the corner that the site is
    int cell_x = cell & 1;
    int cell_y = cell >> 1 & 1;
    int cell_z = cell >> 2;
    Components force = force_of_cell(WITH_ARRAYS at - cell_x - cell_y * from_pitch - cell_z * from_layer,
                                     is_cell(WITH_ARRAYS x - cell_x, y - cell_y, z - cell_z), cell);
    EACH_AXIS {
      line.along[axis] =
          cell_x == 1 ? force.along[axis] : corrected_by_one(line.along[axis], force.along[axis]);
      if (cell_x == 0) {
        slab.along[axis] =
            cell_y == 1 ? line.along[axis] : corrected_by_one(slab.along[axis], line.along[axis]);
      }
      if (cell_x + cell_y == 0) {
        sum.along[axis] =
            cell_z == 1 ? slab.along[axis] : corrected_by_one(sum.along[axis], slab.along[axis]);
      }
    }
  }
  finish_site(WITH_ARRAYS at, first + z * layer + y * pitch + x, sum);
}

// Of the finer level, where it may move.
#define DIAGONAL(axis) (axis == 0 ? 0 : axis == 1 ? 3 : 5)
#define FINE(i) (IS_IMAGE != 0 ? free_part(FROM(i, axis), RESPONSE(i, DIAGONAL(axis))) : FROM(i, axis))
#define FINE_ROW(i) restricted(FINE((i)-1), FINE(i), FINE((i) + 1))
#define FINE_PLANE(i) restricted(FINE_ROW((i)-from_pitch), FINE_ROW(i), FINE_ROW((i) + from_pitch))

// The product of two fields at a site, or what is summed up; 0 beyond the border.
HDM_FUNCTION real term_at(ARRAYS int x, int y, int z) {
  if (x >= from_width || y >= from_height || z >= from_depth) {
    return HDM_NUMBER(0);
  }
  int at = from_first + z * from_layer + y * from_pitch + x;
  if (STEP == ELASTIC_SQUARES) {
    return FROM(at, 0);
  }
  return with_term(site_product(FROM(at, 0), SECOND(at, 0), FROM(at, 1), SECOND(at, 1)), FROM(at, 2),
                   SECOND(at, 2));
}
HDM_FUNCTION real slab_term(ARRAYS int x, int y, int z) {
  return square_sum(term_at(WITH_ARRAYS x, y, z), term_at(WITH_ARRAYS x + 1, y, z),
                    term_at(WITH_ARRAYS x, y + 1, z), term_at(WITH_ARRAYS x + 1, y + 1, z));
}

HDM_FUNCTION void do_site(ARRAYS int x, int y, int z) {
  int to = first + z * layer + y * pitch + x;
  int at = from_first + z * from_layer + y * from_pitch + x; // where from's sites are those of `to`
  Components result;
  EACH_AXIS {
    result.along[axis] = HDM_NUMBER(0);
  }
  if (STEP == ELASTIC_RELAX_FROM_ZERO) {
    EACH_AXIS {
      result.along[axis] = FROM(at, axis);
    }
    finish_site(WITH_ARRAYS at, to, result);
    return;
  }
  if (STEP == ELASTIC_RESTRICT) {
    at += z * from_layer + y * from_pitch + x;
    EACH_AXIS {
      result.along[axis] =
          restricted(FINE_PLANE(at - from_layer), FINE_PLANE(at), FINE_PLANE(at + from_layer));
    }
  } else if (STEP == ELASTIC_INTERPOLATE || STEP == ELASTIC_CORRECT) {
    // Some of the eight coarse sites around may be one.
    int odd_x = x & 1, odd_y = y & 1, odd_z = z & 1;
    int c000 = second_first + z / 2 * second_layer + y / 2 * second_pitch + x / 2;
    int c010 = c000 + odd_y * second_pitch;
    int c001 = c000 + odd_z * second_layer;
    int c011 = c010 + odd_z * second_layer;
    int odd = odd_x + odd_y + odd_z;
    EACH_AXIS {
      real value = STEP == ELASTIC_CORRECT ? FROM(at, axis) : HDM_NUMBER(0);
      real u000 = SECOND(c000, axis), u100 = SECOND(c000 + odd_x, axis), u010 = SECOND(c010, axis);
      real u110 = SECOND(c010 + odd_x, axis), u001 = SECOND(c001, axis), u101 = SECOND(c001 + odd_x, axis);
      real u011 = SECOND(c011, axis), u111 = SECOND(c011 + odd_x, axis);
      real few = odd == 0 ? corrected_by_one(value, u000) : corrected_by_two(value, u000, u111);
      real many =
          odd == 2 ? corrected_by_four(value, u000, odd_x == 1 ? u100 : u010, odd_z == 1 ? u001 : u010, u111)
                   : corrected_by_eight(value, u000, u100, u010, u110, u001, u101, u011, u111);
      bool is_free = RESPONSE(at, DIAGONAL(axis)) > HDM_NUMBER(0);
      result.along[axis] = is_free ? (odd < 2 ? few : many) : value;
    }
  } else if (STEP == ELASTIC_SOLVE) {
    int sites = from_width * from_height * from_depth;
    int site = (z * from_height + y) * from_width + x;
    int column = 0;
    for (int k = 0; k < from_depth; ++k) {
      for (int j = 0; j < from_height; ++j) {
        for (int i = 0; i < from_width; ++i) {
          for (int component = 0; component < 3; ++component) {
            real load = FROM(from_first + k * from_layer + j * from_pitch + i, component);
            EACH_AXIS {
              result.along[axis] = with_term(result.along[axis], INVERSE(column, sites, site, axis), load);
            }
            ++column;
          }
        }
      }
    }
  } else if (STEP == ELASTIC_ADVANCE) {
    EACH_AXIS {
      result.along[axis] = advanced(FROM(at, axis), factor, SECOND(at, axis));
    }
  } else { // a cube of 2 x 2 x 2
    result.along[0] = corrected_by_one(slab_term(WITH_ARRAYS 2 * x, 2 * y, 2 * z),
                                       slab_term(WITH_ARRAYS 2 * x, 2 * y, 2 * z + 1));
  }
  STORE(to, result.along[0], result.along[1], result.along[2]);
}

HDM_FUNCTION void do_item(ARRAYS int item) {
  if (BY_LIST != 0) {
    if (item < listed) {
      int number = listed_first + item;
      sweep_listed(WITH_ARRAYS int_of(TOUCHED(number, 0)), int_of(TOUCHED(number, 1)),
                   int_of(TOUCHED(number, 2)));
    }
    return;
  }
  int across = (width + COLUMNS - 1) / COLUMNS;
  int line = item / across;
  int left = (item - line * across) * COLUMNS;
  int slab = line / height;
  int y = line - slab * height;
  int begin = slab * ROWS;
  int end = begin + ROWS < depth ? begin + ROWS : depth;
  if (begin < depth) {
    if (STEP == ELASTIC_RELAX || STEP == ELASTIC_RESIDUAL) {
      sweep_columns(WITH_ARRAYS left, y, begin, end);
    } else {
      for (int z = begin; z < end; ++z) {
        SITES_SIDE_BY_SIDE
        for (int i = 0; i < COUNT(left); ++i) {
          if (left + i < width) {
            do_site(WITH_ARRAYS left + i, y, z);
          }
        }
      }
    }
  }
}
