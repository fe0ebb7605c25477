// Relax and residual of the elastic energy (elastic_sites.h). A work item goes along z through ROWS sites, of
// COLUMNS columns side by side, so that it fetches each plane once and keeps what a cell does to its far
// corners. Sites beside masked cells are done again, from a list.

#define HDM_BOXES (BOXES != 0)
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

#define bend_of_image REAL_TOLD(26)
#define moments_from TOLD(4)
#define factor REAL_TOLD(5)
#define base (TOGETHER != 0 ? TOLD(5) : 0) // of the arrays that do not change

// Numbers of a site, one for each axis.
struct Components {
  real along[HDM_AXES];
};
// Numbers at the corners of a cell.
struct CellNumbers {
  real at[CORNERS];
};
struct CellComponents {
  CellNumbers along[HDM_AXES];
};
// The sum of the numbers at the corners of a square or a cube: they are added along x, then y, then z.
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

// Where the sites of a level lie in an array.
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

#if TOGETHER == 0
#define DOES(asked) (STEP == asked)
#else
#define DOES(asked) (MY(step) == asked)
#endif
#define AT(of, x, y, z) (MY(of).first + (z)*MY(of).layer + (y)*MY(of).pitch + (x))
// From a cell's first corner to another.
#define TO_CORNER(of, corner)                                                                                \
  (ALONG_Z(corner) * MY(of).layer + ALONG_Y(corner) * MY(of).pitch + ALONG_X(corner))

// Components are prescribed on every level of a volume, of an image on the finest only.
#define CUTS (HDM_AXES == 3 || IS_IMAGE != 0)
#define DIAGONAL(axis) ENTRY(axis, axis)
// The place of an entry of a symmetric matrix, whose upper half is kept row by row.
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
  c.bend = HDM_NUMBER(1), c.volume = c.m;
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
  Law law;
  law.lame = REAL_TOLD(0), law.y = REAL_TOLD(1), law.z = REAL_TOLD(2);
  CellTension tension =
      cell_tension(moments_of_cell, coefficients_of(cell_corners(u.along[0])),
                   coefficients_of(cell_corners(u.along[1])), coefficients_of(cell_corners(u.along[2])), law);
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
  Law law;
  law.nu = REAL_TOLD(0), law.shear = REAL_TOLD(1), law.y = REAL_TOLD(2);
  CellTension tension =
      cell_tension(moments_of_cell, cell_corners(u.along[0]), cell_corners(u.along[1]), law);
  CellComponents forces;
#define FORCE(corner, on)                                                                                    \
  forces.along[0].at[corner] = on(tension, law).x;                                                           \
  forces.along[1].at[corner] = on(tension, law).y
  FORCE(0, force_on_top_left);
  FORCE(1, force_on_top_right);
  FORCE(2, force_on_bottom_left);
  FORCE(3, force_on_bottom_right);
  return forces;
}
#endif

// Returns the forces of a cell that has moments, or in the image of a volume moduli at its corners. Cells of
// the ring around a level have no stiffness: what they would have is not `there`.
HDM_FUNCTION CellComponents forces_of_cell(ARRAYS int i, CellComponents u, CellNumbers moduli, bool there) {
#if HDM_AXES == 3
  if (HAS_MODULI) {
    real none = HDM_NUMBER(0);
    EACH_CORNER {
      moduli.at[corner] = there ? moduli.at[corner] : none;
    }
    return forces_by_moments(WITH_ARRAYS image_cell(cell_corners(moduli), bend_of_image), u);
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
    real straight = RESPONSE(at, DIAGONAL(axis));
    int other = axis == 0 ? 1 : 0;
    real across = RESPONSE(at, ENTRY(axis, other));
#if HDM_AXES == 3
    int second = axis == 2 ? 1 : 2;
    value.along[axis] =
        relaxed_in_volume(value.along[axis], straight, residual.along[axis], across, residual.along[other],
                          RESPONSE(at, ENTRY(axis, second)), residual.along[second]);
#else
    value.along[axis] =
        relaxed(value.along[axis], straight, residual.along[axis], across, residual.along[other]);
#endif
  }
  return value;
}

// The last thing that relax and residual do to a site.
HDM_FUNCTION void finish_site(ARRAYS int at, int to, Components value, Components force) {
  Components load, result;
  if (HAS_LOAD != 0) {
    GET_SECOND(load, at)
  }
  EACH_AXIS {
    force.along[axis] =
        HAS_LOAD != 0 ? corrected_by_one(load.along[axis], force.along[axis]) : force.along[axis];
    result.along[axis] =
        CUTS ? free_part(force.along[axis], RESPONSE(at, DIAGONAL(axis))) : force.along[axis];
  }
  if (DOES(ELASTIC_RELAX)) {
    result = relaxed_site(WITH_ARRAYS at, value, force);
  }
  STORE(to, result)
}

// What a plane has around the columns: rows y - AROUND ... y + AROUND, columns left - 1 ... left + COLUMNS.
#define FETCH_PLANE(u, e, at)                                                                                \
  HDM_UNROLLED                                                                                               \
  for (int row = 0; row < 1 + 2 * AROUND; ++row) {                                                           \
    SITES_SIDE_BY_SIDE                                                                                       \
    for (int i = 0; i < COUNT(left, COLUMNS) + 2; ++i) {                                                     \
      Components site;                                                                                       \
      GET_FROM(site, at + (row - AROUND) * MY(from_place).pitch - 1 + i)                                     \
      EACH_AXIS {                                                                                            \
        u[HDM_AXES * row + axis][i] = site.along[axis];                                                      \
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
  // The forces of cells on sites of row y, by their corner along z, row of cells and corner along x; cell i
  // is to the west of column i. Drivers unroll loops that are as long as an array is.
  real forces[HDM_AXES][2][1 + AROUND][2][COLUMNS + 1];
  real before[HDM_AXES][COLUMNS]; // on a plane's sites, of the cells before it
  int at = AT(from_place, left, y, begin - 1);
  FETCH_PLANE(here, modulus_here, at)
  for (int z = begin - 1; z < end; ++z) {
    FETCH_PLANE(next, modulus_next, at + MY(from_place).layer)
    HDM_UNROLLED
    for (int row = 0; row < 1 + AROUND; ++row) {
      SITES_SIDE_BY_SIDE
      for (int i = 0; i < COUNT(left, COLUMNS) + 1; ++i) {
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
    for (int i = 0; i < COUNT(left, COLUMNS); ++i) {
      Components value, sum;
      EACH_AXIS {
        value.along[axis] = here[HDM_AXES * AROUND + axis][i + 1];
        sum.along[axis] = corrected_by_one(before[axis][i], SLAB_SUM(0));
        before[axis][i] = SLAB_SUM(1);
      }
      if (z >= begin && IS_THERE(left + i)) {
        finish_site(WITH_ARRAYS at + i, AT(place, left + i, y, z), value, sum);
      }
    }
    HDM_UNROLLED
    for (int row = 0; row < 1 + 2 * AROUND; ++row) {
      SITES_SIDE_BY_SIDE
      for (int i = 0; i < COUNT(left, COLUMNS) + 2; ++i) {
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
  Components force, moved;
  CellComponents u;
  CellNumbers moduli;
  EACH_CORNER {
    GET_FROM(moved, i + TO_CORNER(from_place, corner))
    EACH_AXIS {
      u.along[axis].at[corner] = moved.along[axis];
    }
    moduli.at[corner] = MODULUS(i + TO_CORNER(from_place, corner));
  }
  EACH_AXIS {
    force.along[axis] = HDM_NUMBER(0);
  }
  ONLY_WHERE(matrix >= 0) {
    EACH_CORNER {
      int block = (CORNERS * max(matrix, 0) + corner) * CORNERS + to_corner;
      HDM_UNROLLED
      for (int component = 0; component < HDM_AXES; ++component) {
        EACH_AXIS {
          force.along[axis] = masked_force(force.along[axis], MATRIX(block, HDM_AXES * component + axis),
                                           u.along[component].at[corner]);
        }
      }
    }
  }
  ONLY_WHERE(matrix < 0) {
    CellComponents forces = forces_of_cell(WITH_ARRAYS i, u, moduli, there);
    EACH_AXIS {
      force.along[axis] = matrix < 0 ? forces.along[axis].at[to_corner] : force.along[axis];
    }
  }
  return force;
}

// Site `entry` of the list of those beside masked cells: cells along x, then y, then z.
HDM_FUNCTION void sweep_listed(ARRAYS int entry) {
  int x = TOUCHED(entry), y = TOUCHED(entry + 1), z = TOUCHED(entry + 2);
  int at = AT(from_place, x, y, z);
  Components value, force;
  Components by_cell[CORNERS];
  Sum sum[HDM_AXES];
  GET_FROM(value, at)
  HDM_UNROLLED
  for (int cell = 0; cell < CORNERS; ++cell) {
    int corner = CORNERS - 1 - cell; // that the site is
    by_cell[cell] =
        force_on_corner(WITH_ARRAYS at - TO_CORNER(from_place, corner),
                        is_cell(WITH_ARRAYS x - ALONG_X(corner), y - ALONG_Y(corner), z - ALONG_Z(corner)),
                        corner, TOUCHED(entry + 4 + cell));
    EACH_AXIS {
      sum[axis] = with_number(sum[axis], cell, by_cell[cell].along[axis]);
    }
  }
  EACH_AXIS {
    force.along[axis] = sum[axis].all;
  }
  finish_site(WITH_ARRAYS at, AT(place, x, y, z), value, force);
}
