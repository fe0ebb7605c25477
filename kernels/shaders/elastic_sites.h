// Steps of the elastic energy on all sites of a level, of images and of volumes, as every kind of GLSL from
// 4.30 on and as OpenCL C. An image is a volume without the middle axis: x runs along a row, z from row to
// row, and y is 0. A work item goes along z through ROWS sites, of COLUMNS columns side by side, so that
// relax and residual fetch each plane once and keep what a cell does to its far corners. Sites beside masked
// cells are done again, from a list. Compiled after the macros of the specification; the includer supplies
//
//   HDM_AXES                           2, an image, or 3, a volume
//   STEP, HAS_LOAD, IS_IMAGE, BY_LIST  ElasticKernel, numbers
//   COLUMNS, ROWS                      of a work item
//   TOGETHER                           not 0: one work group does several steps, as ElasticTogether says
//   COUNT(left)                        of the columns, how many are computed: may be more than there are
//   ARRAYS, WITH_ARRAYS                parameter and argument of the functions that use what follows, with a
//                                      comma
//   MY(name), WORK_OF_ITEM             a variable of the struct Work; declares it where it is not an argument
//   TOLD(i), REAL_TOLD(i)              word i of ElasticParameters or ElasticTogether
//   FROM(i, axis), SECOND(i, axis), STORE(i, components)
//   RESPONSE(i, entry), MOMENT(i, number), MATRIX(i), INVERSE(i), TOUCHED(i)
//   WAIT_FOR_ALL                       where several steps are done
//   SITES_SIDE_BY_SIDE                 stands before loops over columns
//   ONLY_IF(condition)                 stands before a block

#include "elastic/site.inc"
#if HDM_AXES == 3
#include "elastic/volume.inc"
#else
#include "elastic/cell.inc"
#endif
#include "elastic_steps.h"

#ifndef HDM_UNROLLED
#define HDM_UNROLLED
#endif
#define EACH_AXIS HDM_UNROLLED for (int axis = 0; axis < HDM_AXES; ++axis)
#define EACH_CORNER HDM_UNROLLED for (int corner = 0; corner < CORNERS; ++corner)

// Rows of a plane beside the one of a site, on each side; the corners of a cell, numbered with x in the
// lowest bit and z in the highest.
#define AROUND (HDM_AXES - 2)
#define CORNERS (1 << HDM_AXES)
#define ALONG_X(corner) ((corner)&1)
#define ALONG_Y(corner) ((corner) >> 1 & AROUND)
#define ALONG_Z(corner) ((corner) >> (HDM_AXES - 1))

#define lame REAL_TOLD(2)
#define moments_from TOLD(4)
#define factor REAL_TOLD(5)
#define base (TOGETHER != 0 ? TOLD(5) : 0) // of the arrays that do not change

// Of a site.
struct Components {
  real along[HDM_AXES];
};
// At the corners of a cell.
struct CellNumbers {
  real at[CORNERS];
};
struct CellComponents {
  CellNumbers along[HDM_AXES];
};
// Of numbers at the corners of a square or a cube, added in reading order: along x, then y, then z.
struct Sum {
  real line, slab, all;
};
HDM_FUNCTION Sum with_number(Sum sum, int corner, real number) {
  sum.line = ALONG_X(corner) == 0 ? number : corrected_by_one(sum.line, number);
  if (ALONG_X(corner) == 1) {
    sum.slab = ALONG_Y(corner) == 0 ? sum.line : corrected_by_one(sum.slab, sum.line);
  }
  if (ALONG_X(corner) == 1 && ALONG_Y(corner) == AROUND) {
    sum.all = ALONG_Z(corner) == 0 ? sum.slab : corrected_by_one(sum.all, sum.slab);
  }
  return sum;
}

// Of the sites of a level in an array.
struct Place {
  int width, height, depth;
  int first, pitch, layer; // site (0, 0, 0), from a row to the next, from a plane to the next
};
// What a work item does: the step, from fields at `from_place` and `second_place` to one at `place`. Where
// several steps are done, which of the three fields of a level they are.
struct Work {
  int step;
  Place place, from_place, second_place;
  int from_slot, second_slot, stored_slot;
};
WORK_OF_ITEM
#define AT(of, x, y, z) (MY(of).first + (z)*MY(of).layer + (y)*MY(of).pitch + (x))
// From a cell's first corner to another.
#define TO_CORNER(of, corner)                                                                                \
  (ALONG_Z(corner) * MY(of).layer + ALONG_Y(corner) * MY(of).pitch + ALONG_X(corner))

// Components are prescribed on every level of a volume, of an image on the finest only.
#define CUTS (HDM_AXES == 3 || IS_IMAGE != 0)
#define DIAGONAL(axis) ENTRY(axis, axis)
// Of a symmetric matrix, the upper half row by row.
#define ENTRY(a, b)                                                                                          \
  ((a) < (b) ? (a) * (2 * HDM_AXES - 1 - (a)) / 2 + (b) : (b) * (2 * HDM_AXES - 1 - (b)) / 2 + (a))

#if HDM_AXES == 3
#define HAS_MODULI (IS_IMAGE != 0)
#define MODULUS(i) RESPONSE(i, 6)

HDM_FUNCTION CellCorners cell_corners(CellNumbers c) {
  CellCorners of;
  of.c000 = c.at[0], of.c100 = c.at[1], of.c010 = c.at[2], of.c110 = c.at[3];
  of.c001 = c.at[4], of.c101 = c.at[5], of.c011 = c.at[6], of.c111 = c.at[7];
  return of;
}

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

HDM_FUNCTION CellNumbers corner_forces(Coefficients tension) {
  CellCorners f = forces_of(tension);
  CellNumbers forces;
  forces.at[0] = f.c000, forces.at[1] = f.c100, forces.at[2] = f.c010, forces.at[3] = f.c110;
  forces.at[4] = f.c001, forces.at[5] = f.c101, forces.at[6] = f.c011, forces.at[7] = f.c111;
  return forces;
}

HDM_FUNCTION CellComponents forces_by_moments(ARRAYS CellMoments moments_of_cell, CellComponents u) {
  CellTension tension = cell_tension(moments_of_cell, coefficients_of(cell_corners(u.along[0])),
                                     coefficients_of(cell_corners(u.along[1])),
                                     coefficients_of(cell_corners(u.along[2])), lame);
  CellComponents forces;
  forces.along[0] = corner_forces(tension.x);
  forces.along[1] = corner_forces(tension.y);
  forces.along[2] = corner_forces(tension.z);
  return forces;
}

#else
#define HAS_MODULI false
#define MODULUS(i) HDM_NUMBER(0)

HDM_FUNCTION CellCorners cell_corners(CellNumbers c) {
  CellCorners of;
  of.top_left = c.at[0], of.top_right = c.at[1], of.bottom_left = c.at[2], of.bottom_right = c.at[3];
  return of;
}

HDM_FUNCTION CellMoments moments_at(ARRAYS int i) {
  CellMoments c;
  c.m = MOMENT(i, 0), c.mr = MOMENT(i, 1), c.ms = MOMENT(i, 2);
  c.mrr = MOMENT(i, 3), c.mss = MOMENT(i, 4), c.mrs = MOMENT(i, 5);
  return c;
}

HDM_FUNCTION CellComponents forces_by_moments(ARRAYS CellMoments moments_of_cell, CellComponents u) {
  PoissonRatio ratio;
  ratio.nu = REAL_TOLD(0), ratio.shear = REAL_TOLD(1);
  CellTension tension =
      cell_tension(moments_of_cell, cell_corners(u.along[0]), cell_corners(u.along[1]), ratio);
  CellComponents forces;
#define FORCE(corner, on)                                                                                    \
  forces.along[0].at[corner] = on(tension).x;                                                                \
  forces.along[1].at[corner] = on(tension).y
  FORCE(0, force_on_top_left);
  FORCE(1, force_on_top_right);
  FORCE(2, force_on_bottom_left);
  FORCE(3, force_on_bottom_right);
  return forces;
}
#endif

// Of a cell that has moments, or of the image of a volume moduli at its corners. Cells of the ring around a
// level have no stiffness: what they would have is not `there`.
HDM_FUNCTION CellComponents forces_of_cell(ARRAYS int i, CellComponents u, CellNumbers moduli, bool there) {
#if HDM_AXES == 3
  if (HAS_MODULI) {
    real none = HDM_NUMBER(0);
    EACH_CORNER {
      moduli.at[corner] = there ? moduli.at[corner] : none;
    }
    return forces_by_moments(WITH_ARRAYS image_cell(cell_corners(moduli)), u);
  }
#endif
  return forces_by_moments(WITH_ARRAYS moments_at(WITH_ARRAYS i), u);
}

HDM_FUNCTION bool is_cell(ARRAYS int x, int y, int z) {
  return x >= 0 && y >= 0 && z >= 0 && x < MY(from_place).width - 1 && y < MY(from_place).height - AROUND &&
         z < MY(from_place).depth - 1;
}

// Site `at` after a sweep, by what is left to be balanced.
HDM_FUNCTION Components relaxed_site(ARRAYS int at, Components value, Components residual) {
  EACH_AXIS {
    real moved = with_term(value.along[axis], RESPONSE(at, DIAGONAL(axis)), residual.along[axis]);
    HDM_UNROLLED
    for (int other = 0; other < HDM_AXES; ++other) {
      if (other != axis) {
        moved = with_term(moved, RESPONSE(at, ENTRY(axis, other)), residual.along[other]);
      }
    }
    value.along[axis] = moved;
  }
  return value;
}

// The last thing that relax and residual do to a site.
HDM_FUNCTION void finish_site(ARRAYS int at, int to, Components value, Components force) {
  Components result;
  EACH_AXIS {
    force.along[axis] =
        HAS_LOAD != 0 ? corrected_by_one(SECOND(at, axis), force.along[axis]) : force.along[axis];
    result.along[axis] =
        CUTS ? free_part(force.along[axis], RESPONSE(at, DIAGONAL(axis))) : force.along[axis];
  }
  if (MY(step) == ELASTIC_RELAX) {
    result = relaxed_site(WITH_ARRAYS at, value, force);
  }
  STORE(to, result);
}

// What a plane has around the columns: rows y - AROUND ... y + AROUND, columns left - 1 ... left + COLUMNS.
#define FETCH_PLANE(u, e, at)                                                                                \
  HDM_UNROLLED                                                                                               \
  for (int row = 0; row < 1 + 2 * AROUND; ++row) {                                                           \
    SITES_SIDE_BY_SIDE                                                                                       \
    for (int i = 0; i < COUNT(left) + 2; ++i) {                                                              \
      EACH_AXIS {                                                                                            \
        u[HDM_AXES * row + axis][i] = FROM(at + (row - AROUND) * MY(from_place).pitch - 1 + i, axis);        \
      }                                                                                                      \
      if (HAS_MODULI) {                                                                                      \
        e[row][i] = MODULUS(at + (row - AROUND) * MY(from_place).pitch - 1 + i);                             \
      }                                                                                                      \
    }                                                                                                        \
  }
// The sum of the cells beside site i that lie before its plane (1) or after it (0): along x, then y.
#define LINE_SUM(z, row) corrected_by_one(forces[axis][z][row][1][i], forces[axis][z][row][0][i + 1])
#if HDM_AXES == 3
#define SLAB_SUM(z) corrected_by_one(LINE_SUM(z, 0), LINE_SUM(z, 1))
#else
#define SLAB_SUM(z) LINE_SUM(z, 0)
#endif

HDM_FUNCTION void sweep_columns(ARRAYS int left, int y, int begin, int end) {
  real here[HDM_AXES * (1 + 2 * AROUND)][COLUMNS + 2]; // displacements on a plane, row by row
  real next[HDM_AXES * (1 + 2 * AROUND)][COLUMNS + 2]; // and on the next
  real modulus_here[1 + 2 * AROUND][COLUMNS + 2];
  real modulus_next[1 + 2 * AROUND][COLUMNS + 2];
  // Of cells on sites of row y, by their corner along z, row of cells and corner along x; cell i is to the
  // west of column i. Drivers unroll loops that are as long as an array is.
  real forces[HDM_AXES][2][1 + AROUND][2][COLUMNS + 1];
  real before[HDM_AXES][COLUMNS]; // on a plane's sites, of the cells before it
  int at = AT(from_place, left, y, begin - 1);
  FETCH_PLANE(here, modulus_here, at)
  for (int z = begin - 1; z < end; ++z) {
    FETCH_PLANE(next, modulus_next, at + MY(from_place).layer)
    HDM_UNROLLED
    for (int row = 0; row < 1 + AROUND; ++row) {
      SITES_SIDE_BY_SIDE
      for (int i = 0; i < COUNT(left) + 1; ++i) {
        CellComponents u;
        CellNumbers moduli;
        EACH_CORNER {
          int r = row + ALONG_Y(corner);
          EACH_AXIS {
            u.along[axis].at[corner] = ALONG_Z(corner) == 1 ? next[HDM_AXES * r + axis][i + ALONG_X(corner)]
                                                            : here[HDM_AXES * r + axis][i + ALONG_X(corner)];
          }
          moduli.at[corner] = !HAS_MODULI            ? HDM_NUMBER(0)
                              : ALONG_Z(corner) == 1 ? modulus_next[r][i + ALONG_X(corner)]
                                                     : modulus_here[r][i + ALONG_X(corner)];
        }
        CellComponents force =
            forces_of_cell(WITH_ARRAYS at + (row - AROUND) * MY(from_place).pitch - 1 + i, u, moduli,
                           is_cell(WITH_ARRAYS left - 1 + i, y - AROUND + row, z));
        EACH_CORNER {
          if (ALONG_Y(corner) == AROUND - row) {
            EACH_AXIS {
              forces[axis][ALONG_Z(corner)][row][ALONG_X(corner)][i] = force.along[axis].at[corner];
            }
          }
        }
      }
    }
    SITES_SIDE_BY_SIDE
    for (int i = 0; i < COUNT(left); ++i) {
      Components value, sum;
      EACH_AXIS {
        value.along[axis] = here[HDM_AXES * AROUND + axis][i + 1];
        sum.along[axis] = corrected_by_one(before[axis][i], SLAB_SUM(0));
        before[axis][i] = SLAB_SUM(1);
      }
      if (z >= begin && left + i < MY(place).width) {
        finish_site(WITH_ARRAYS at + i, AT(place, left + i, y, z), value, sum);
      }
    }
    HDM_UNROLLED
    for (int row = 0; row < 1 + 2 * AROUND; ++row) {
      SITES_SIDE_BY_SIDE
      for (int i = 0; i < COUNT(left) + 2; ++i) {
        EACH_AXIS {
          here[HDM_AXES * row + axis][i] = next[HDM_AXES * row + axis][i];
        }
        modulus_here[row][i] = modulus_next[row][i];
      }
    }
    at += MY(from_place).layer;
  }
}

// What cell i, which has a matrix or none (-1), does to its corner.
HDM_FUNCTION Components force_on_corner(ARRAYS int i, bool there, int to_corner, int matrix) {
  CellComponents u;
  CellNumbers moduli;
  Components force, by_matrix;
  EACH_AXIS {
    by_matrix.along[axis] = HDM_NUMBER(0);
  }
  EACH_CORNER {
    int site = i + TO_CORNER(from_place, corner);
    EACH_AXIS {
      u.along[axis].at[corner] = FROM(site, axis);
    }
    moduli.at[corner] = MODULUS(site);
    if (matrix >= 0) {
      for (int component = 0; component < HDM_AXES; ++component) {
        int column = (HDM_AXES * CORNERS * matrix + HDM_AXES * corner + component) * HDM_AXES * CORNERS;
        EACH_AXIS {
          by_matrix.along[axis] =
              masked_force(by_matrix.along[axis], MATRIX(column + HDM_AXES * to_corner + axis),
                           u.along[component].at[corner]);
        }
      }
    }
  }
  CellComponents by_moments = forces_of_cell(WITH_ARRAYS i, u, moduli, there);
  EACH_AXIS {
    force.along[axis] = matrix >= 0 ? by_matrix.along[axis] : by_moments.along[axis].at[to_corner];
  }
  return force;
}

// Site `entry` of the list of those beside masked cells: cells along x, then y, then z.
HDM_FUNCTION void sweep_listed(ARRAYS int entry) {
  int x = TOUCHED(entry), y = TOUCHED(entry + 1), z = TOUCHED(entry + 2);
  int at = AT(from_place, x, y, z);
  Components value, force;
  Sum sum[HDM_AXES];
  EACH_AXIS {
    value.along[axis] = FROM(at, axis);
  }
  HDM_UNROLLED
  for (int cell = 0; cell < CORNERS; ++cell) {
    int corner = CORNERS - 1 - cell; // that the site is
    force =
        force_on_corner(WITH_ARRAYS at - TO_CORNER(from_place, corner),
                        is_cell(WITH_ARRAYS x - ALONG_X(corner), y - ALONG_Y(corner), z - ALONG_Z(corner)),
                        corner, TOUCHED(entry + 4 + cell));
    EACH_AXIS {
      sum[axis] = with_number(sum[axis], cell, force.along[axis]);
    }
  }
  EACH_AXIS {
    force.along[axis] = sum[axis].all;
  }
  finish_site(WITH_ARRAYS at, AT(place, x, y, z), value, force);
}

// Of the finer level, where it may move.
#define CUTS_FINE (TOGETHER != 0 ? HDM_AXES == 3 : IS_IMAGE != 0)
#define FINE(i) (CUTS_FINE ? free_part(FROM(i, axis), RESPONSE(i, DIAGONAL(axis))) : FROM(i, axis))
#define FINE_LINE(i) restricted(FINE((i)-1), FINE(i), FINE((i) + 1))
#if HDM_AXES == 3
#define FINE_PLANE(i)                                                                                        \
  restricted(FINE_LINE((i)-MY(from_place).pitch), FINE_LINE(i), FINE_LINE((i) + MY(from_place).pitch))
#else
#define FINE_PLANE(i) FINE_LINE(i)
#endif

HDM_FUNCTION Components restricted_site(ARRAYS int at) {
  Components result;
  EACH_AXIS {
    result.along[axis] = restricted(FINE_PLANE(at - MY(from_place).layer), FINE_PLANE(at),
                                    FINE_PLANE(at + MY(from_place).layer));
  }
  return result;
}

// Some of the coarse sites around may be one.
HDM_FUNCTION Components corrected_site(ARRAYS int x, int y, int z) {
  int at = AT(place, x, y, z);
  int odd_x = x & 1, odd_y = y & 1, odd_z = z & 1;
  int odd = odd_x + odd_y + odd_z;
  int coarse = AT(second_place, x / 2, y / 2, z / 2);
  Components result;
  EACH_AXIS {
    real c[CORNERS];
    EACH_CORNER {
      c[corner] = SECOND(coarse + odd_x * ALONG_X(corner) + odd_y * ALONG_Y(corner) * MY(second_place).pitch +
                             odd_z * ALONG_Z(corner) * MY(second_place).layer,
                         axis);
    }
    real value = MY(step) == ELASTIC_CORRECT ? FROM(at, axis) : HDM_NUMBER(0);
    real few = odd == 0 ? corrected_by_one(value, c[0]) : corrected_by_two(value, c[0], c[CORNERS - 1]);
#if HDM_AXES == 3
    real many = odd == 2
                    ? corrected_by_four(value, c[0], odd_x == 1 ? c[1] : c[2], odd_z == 1 ? c[4] : c[2], c[7])
                    : corrected_by_eight(value, c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]);
#else
    real many = corrected_by_four(value, c[0], c[1], c[2], c[3]);
#endif
    real corrected = odd < 2 ? few : many;
    result.along[axis] =
        CUTS ? (RESPONSE(at, DIAGONAL(axis)) > HDM_NUMBER(0) ? corrected : value) : corrected;
  }
  return result;
}

HDM_FUNCTION Components solved_site(ARRAYS int x, int y, int z) {
  Place all = MY(from_place);
  int rows = HDM_AXES * all.width * all.height * all.depth;
  int entry = HDM_AXES * ((z * all.height + y) * all.width + x); // of a column of the inverse
  Components result;
  EACH_AXIS {
    result.along[axis] = HDM_NUMBER(0);
  }
  for (int k = 0; k < all.depth; ++k) {
    for (int j = 0; j < all.height; ++j) {
      for (int i = 0; i < all.width; ++i) {
        for (int component = 0; component < HDM_AXES; ++component) {
          real load = FROM(AT(from_place, i, j, k), component);
          EACH_AXIS {
            result.along[axis] = with_term(result.along[axis], INVERSE(entry + axis), load);
          }
          entry += rows;
        }
      }
    }
  }
  return result;
}

// The product of two fields at a site, or what is summed up; 0 beyond the border. Without a branch: there are
// many in a row, and a compiler that looks for paths through them doubles its search with each.
HDM_FUNCTION real term_at(ARRAYS int x, int y, int z) {
  Place all = MY(from_place);
  int at = AT(from_place, min(x, all.width - 1), min(y, all.height - 1), min(z, all.depth - 1));
  real term = FROM(at, 0);
  if (MY(step) != ELASTIC_SQUARES) {
    term = site_product(term, SECOND(at, 0), FROM(at, 1), SECOND(at, 1));
    for (int axis = 2; axis < HDM_AXES; ++axis) {
      term = with_term(term, FROM(at, axis), SECOND(at, axis));
    }
  }
  real none = HDM_NUMBER(0);
  return x < all.width && y < all.height && z < all.depth ? term : none;
}

// Of a block of ELASTIC_BLOCK sites a side.
HDM_FUNCTION real block_sum(ARRAYS int x, int y, int z) {
  Sum blocks;
  EACH_CORNER {
    Sum sum;
    HDM_UNROLLED
    for (int site = 0; site < CORNERS; ++site) {
      sum = with_number(sum, site,
                        term_at(WITH_ARRAYS ELASTIC_BLOCK * x + 2 * ALONG_X(corner) + ALONG_X(site),
                                ELASTIC_BLOCK * y + 2 * ALONG_Y(corner) + ALONG_Y(site),
                                ELASTIC_BLOCK * z + 2 * ALONG_Z(corner) + ALONG_Z(site)));
    }
    blocks = with_number(blocks, corner, sum.all);
  }
  return blocks.all;
}

HDM_FUNCTION void do_site(ARRAYS int x, int y, int z) {
  int at = AT(from_place, x, y, z); // where from's sites are those of `place`
  Components value, other;
  EACH_AXIS {
    value.along[axis] = HDM_NUMBER(0);
  }
  ONLY_IF(MY(step) == ELASTIC_RELAX_FROM_ZERO) {
    EACH_AXIS {
      other.along[axis] = FROM(at, axis);
    }
    value = relaxed_site(WITH_ARRAYS at, value, other);
  }
  ONLY_IF(MY(step) == ELASTIC_RESTRICT) {
    value = restricted_site(WITH_ARRAYS AT(from_place, 2 * x, 2 * y, 2 * z));
  }
  ONLY_IF(MY(step) == ELASTIC_INTERPOLATE || MY(step) == ELASTIC_CORRECT) {
    value = corrected_site(WITH_ARRAYS x, y, z);
  }
  ONLY_IF(MY(step) == ELASTIC_SOLVE) {
    value = solved_site(WITH_ARRAYS x, y, z);
  }
#if TOGETHER == 0
  if (MY(step) == ELASTIC_ADVANCE) {
    EACH_AXIS {
      value.along[axis] = advanced(FROM(at, axis), factor, SECOND(at, axis));
    }
  } else if (MY(step) > ELASTIC_ADVANCE) {
    value.along[0] = block_sum(WITH_ARRAYS x, y, z);
  }
#endif
  STORE(AT(place, x, y, z), value);
}

// The share of a work item among so many; sites of a list, `count` from word `first` on.
HDM_FUNCTION void do_list(ARRAYS int item, int items, int first, int count) {
  for (int i = item; i < count; i += items) {
    sweep_listed(WITH_ARRAYS first + (4 + CORNERS) * i);
  }
}
HDM_FUNCTION void do_step(ARRAYS int item, int items) {
  Place all = MY(place);
  bool sweeps = MY(step) == ELASTIC_RELAX || MY(step) == ELASTIC_RESIDUAL;
  int across = (all.width + COLUMNS - 1) / COLUMNS;
  int count = across * all.height * ((all.depth + ROWS - 1) / ROWS);
  for (int number = item; number < count; number += items) {
    int line = number / across;
    int left = (number - line * across) * COLUMNS;
    int slab = line / all.height;
    int y = line - slab * all.height;
    int begin = slab * ROWS;
    int end = min(begin + ROWS, all.depth);
    ONLY_IF(sweeps) {
      sweep_columns(WITH_ARRAYS left, y, begin, end);
    }
    int last = sweeps ? begin : end;
    for (int z = begin; z < last; ++z) {
      SITES_SIDE_BY_SIDE
      for (int i = 0; i < COUNT(left); ++i) {
        if (left + i < all.width) {
          do_site(WITH_ARRAYS left + i, y, z);
        }
      }
    }
  }
}

// The six words of a Place.
HDM_FUNCTION Place place_told(ARRAYS int word) {
  Place of;
  of.width = TOLD(word), of.height = TOLD(word + 1), of.depth = TOLD(word + 2);
  of.first = TOLD(word + 3), of.pitch = TOLD(word + 4), of.layer = TOLD(word + 5);
  return of;
}

// Of a level, counted from the finest one that is computed together with others.
HDM_FUNCTION Place place_of(ARRAYS int level) {
  Place of;
  of.width = TOLD(8), of.height = TOLD(9), of.depth = TOLD(10), of.first = 0;
  for (int i = 0; i <= level; ++i) {
    of.pitch = of.width + 3;
    of.layer = of.pitch * (of.height + 3 * AROUND);
    if (i < level) {
      of.first += of.layer * (of.depth + 3);
      of.width = of.width / 2 + 1, of.height = AROUND * (of.height / 2) + 1, of.depth = of.depth / 2 + 1;
    }
  }
  of.first += of.layer + of.pitch * AROUND + 1;
  return of;
}

// All that a dispatch does, as work item `item` of so many.
HDM_FUNCTION void do_share(ARRAYS int item, int items) {
#if TOGETHER == 0
  MY(step) = STEP;
  MY(place) = place_told(WITH_ARRAYS 8);
  MY(from_place) = place_told(WITH_ARRAYS 14);
  MY(second_place) = place_told(WITH_ARRAYS 20);
  if (BY_LIST != 0) {
    do_list(WITH_ARRAYS item, items, TOLD(6), TOLD(7));
  } else {
    do_step(WITH_ARRAYS item, items);
  }
#else
  for (int number = 0; number < TOLD(11); ++number) {
    int code = TOLD(12 + number);
    int level = code >> 10;
    MY(step) = code & 15;
    MY(from_slot) = code >> 4 & 3;
    MY(second_slot) = code >> 6 & 3;
    MY(stored_slot) = code >> 8 & 3;
    bool from_coarser = MY(step) == ELASTIC_INTERPOLATE || MY(step) == ELASTIC_CORRECT;
    MY(from_place) = place_of(WITH_ARRAYS level);
    MY(second_place) = place_of(WITH_ARRAYS from_coarser ? level + 1 : level);
    MY(place) = place_of(WITH_ARRAYS MY(step) == ELASTIC_RESTRICT ? level + 1 : level);
    do_step(WITH_ARRAYS item, items);
    WAIT_FOR_ALL;
    bool sweeps = MY(step) == ELASTIC_RELAX || MY(step) == ELASTIC_RESIDUAL;
    int list = 2 * (TOLD(7) + level);
    do_list(WITH_ARRAYS item, items, TOUCHED(list), sweeps ? TOUCHED(list + 1) : 0);
    WAIT_FOR_ALL;
  }
#endif
}
