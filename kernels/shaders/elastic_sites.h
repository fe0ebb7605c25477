// Steps of the elastic energy on all sites of a level, of images and of volumes, as every kind of GLSL from
// 4.30 on, as OpenCL C and as WGSL. An image is a volume without the middle axis: x runs along a row, z from
// row to row, and y is 0. The includer supplies the macros of the specification and
//
// - HDM_AXES: 2, an image, or 3, a volume.
// - STEP, HAS_LOAD, IS_IMAGE, BY_LIST, BOXES, HALVED: the numbers of an ElasticKernel.
// - COLUMNS, ROWS: the sites that a work item sweeps, side by side and along z.
// - SITE_COLUMNS, SITE_ROWS: the same for the other steps.
// - TOGETHER: not 0 where one work group does several steps, as ElasticTogether says.
// - COUNT(left, columns): how many of these columns from `left` on are computed.
// - IS_THERE(column): whether the level has this column.
// - ARRAYS, WITH_ARRAYS: parameter and argument of functions that use what follows, with a comma.
// - MY(name): a variable of the struct Work. WORK_OF_ITEM declares one where it is no argument.
// - TOLD(i), REAL_TOLD(i): word i of ElasticParameters or ElasticTogether.
// - CODE_TOLD(number): one of the codes of ElasticTogether.
// - GET_FROM(components, i), GET_SECOND(components, i): assign what a field has at a site.
// - STORE(i, components): stores them.
// - RESPONSE(i, entry), MOMENT(i, number): the numbers of a site and of a cell that do not change.
// - GET_INVERSE(components, i): assigns the rows of a site, column by column, site by site.
// - MATRIX(block, number): a number of a masked cell, whose blocks are the force on one corner by another,
//   column by column.
// - TOUCHED(i): word i of touched_sites().
// - WAIT_FOR_ALL: stands between two steps.
// - SITES_SIDE_BY_SIDE: stands before loops over columns.
// - ONLY_WHERE(condition): stands before a block that does nothing of use where the condition does not hold.

#include "elastic_sweep.h"

// Returns a site of the finer level, 0 where it may not move.
HDM_FUNCTION Components fine_site(ARRAYS int at) {
  Components fine;
  GET_FROM(fine, at)
  if (TOGETHER != 0 ? HDM_AXES == 3 : IS_IMAGE != 0) {
    EACH_AXIS {
      fine.along[axis] = free_part(fine.along[axis], RESPONSE(at, DIAGONAL(axis)));
    }
  }
  return fine;
}
HDM_FUNCTION Components restricted_three(Components before, Components at, Components after) {
  EACH_AXIS {
    at.along[axis] = restricted(before.along[axis], at.along[axis], after.along[axis]);
  }
  return at;
}
// 1 along axes where the coarser level has every other site, else 0: it has all of them.
#define HALVED_X (HALVED & 1)
#define HALVED_Y (HALVED >> 1 & 1)
#define HALVED_Z (HALVED >> 2 & 1)
#define THREE(of, at, apart)                                                                                 \
  restricted_three(of(WITH_ARRAYS at - apart), of(WITH_ARRAYS at), of(WITH_ARRAYS at + apart))
HDM_FUNCTION Components fine_line(ARRAYS int at) {
  if (HALVED_X == 0) {
    return fine_site(WITH_ARRAYS at);
  }
  return THREE(fine_site, at, 1);
}
HDM_FUNCTION Components fine_plane(ARRAYS int at) {
#if HDM_AXES == 3
  if (HALVED_Y == 0) {
    return fine_line(WITH_ARRAYS at);
  }
  return THREE(fine_line, at, MY(from_place).pitch);
#else
  return fine_line(WITH_ARRAYS at);
#endif
}
HDM_FUNCTION Components restricted_site(ARRAYS int x, int y, int z) {
  int at = AT(from_place, x << HALVED_X, y << HALVED_Y, z << HALVED_Z);
  if (HALVED_Z == 0) {
    return fine_plane(WITH_ARRAYS at);
  }
  return THREE(fine_plane, at, MY(from_place).layer);
}

HDM_FUNCTION Components relaxed_from_zero(ARRAYS int x, int y, int z) {
  Components zero, load;
  GET_FROM(load, AT(from_place, x, y, z))
  EACH_AXIS {
    zero.along[axis] = HDM_NUMBER(0);
  }
  return relaxed_site(WITH_ARRAYS AT(from_place, x, y, z), zero, load);
}

HDM_FUNCTION Components advanced_site(ARRAYS int x, int y, int z) {
  Components value, direction;
  GET_FROM(value, AT(from_place, x, y, z))
  GET_SECOND(direction, AT(from_place, x, y, z))
  EACH_AXIS {
    value.along[axis] = advanced(value.along[axis], factor, direction.along[axis]);
  }
  return value;
}

// Some of the coarse sites around may be one.
HDM_FUNCTION Components corrected_site(ARRAYS int x, int y, int z) {
  int at = AT(from_place, x, y, z);
  int odd_x = x & HALVED_X, odd_y = y & HALVED_Y, odd_z = z & HALVED_Z;
  int odd = odd_x + odd_y + odd_z;
  int coarse = AT(second_place, x >> HALVED_X, y >> HALVED_Y, z >> HALVED_Z);
  Components around[CORNERS];
  EACH_CORNER{GET_SECOND(around[corner],
                         coarse + odd_x * ALONG_X(corner) + odd_y * ALONG_Y(corner) * MY(second_place).pitch +
                             odd_z * ALONG_Z(corner) * MY(second_place).layer)} Components value;
  GET_FROM(value, at)
  EACH_AXIS {
    real c[CORNERS];
    EACH_CORNER {
      c[corner] = around[corner].along[axis];
    }
    real before = DOES(ELASTIC_CORRECT) ? value.along[axis] : HDM_NUMBER(0);
    real one = corrected_by_one(before, c[0]);
    real two = corrected_by_two(before, c[0], c[CORNERS - 1]);
#if HDM_AXES == 3
    real four = corrected_by_four(before, c[0], odd_x == 1 ? c[1] : c[2], odd_z == 1 ? c[4] : c[2], c[7]);
    real many = corrected_by_eight(before, c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]);
    many = odd == 2 ? four : many;
#else
    real many = corrected_by_four(before, c[0], c[1], c[2], c[3]);
#endif
    real corrected = odd == 0 ? one : odd == 1 ? two : many;
    value.along[axis] =
        CUTS ? (RESPONSE(at, DIAGONAL(axis)) > HDM_NUMBER(0) ? corrected : before) : corrected;
  }
  return value;
}

HDM_FUNCTION Components solved_site(ARRAYS int x, int y, int z) {
  Place all = MY(from_place);
  int entry = (z * all.height + y) * all.width + x; // of a column of the inverse
  Components result, load, column;
  EACH_AXIS {
    result.along[axis] = HDM_NUMBER(0);
  }
  for (int k = 0; k < all.depth; ++k) {
    for (int j = 0; j < all.height; ++j) {
      for (int i = 0; i < all.width; ++i) {
        GET_FROM(load, AT(from_place, i, j, k))
        HDM_UNROLLED
        for (int component = 0; component < HDM_AXES; ++component) {
          GET_INVERSE(column, entry)
          EACH_AXIS {
            result.along[axis] = with_term(result.along[axis], column.along[axis], load.along[component]);
          }
          entry += all.width * all.height * all.depth;
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
  Components first, other;
  GET_FROM(first, at)
  real term = first.along[0];
  if (!DOES(ELASTIC_SQUARES)) {
    GET_SECOND(other, at)
    term = site_product(term, other.along[0], first.along[1], other.along[1]);
#if HDM_AXES == 3
    term = with_term(term, first.along[2], other.along[2]);
#endif
  }
  real none = HDM_NUMBER(0);
  return x < all.width && y < all.height && z < all.depth ? term : none;
}

// Returns the sum of a block of ELASTIC_BLOCK sites a side, as x.
HDM_FUNCTION Components block_sum(ARRAYS int x, int y, int z) {
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
  Components result;
  EACH_AXIS {
    result.along[axis] = axis == 0 ? blocks.all : HDM_NUMBER(0);
  }
  return result;
}

// The share of a work item among so many: of the list of `count` sites from word `first` on, and of the sites
// of a level. A loop for each step: rasterizers on the CPU execute both sides of a branch, but leave a loop
// when all are done.
HDM_FUNCTION void do_list(ARRAYS int item, int items, int first, int count) {
  for (int i = item; i < count; i += items) {
    sweep_listed(WITH_ARRAYS first + (4 + CORNERS) * i);
  }
}

// The sites of a work item.
struct Strip {
  int left, y, begin, end;
};
HDM_FUNCTION int strip_count(ARRAYS int columns, int rows) {
  return (MY(place).width + columns - 1) / columns * MY(place).height * ((MY(place).depth + rows - 1) / rows);
}
HDM_FUNCTION Strip strip_of(ARRAYS int number, int columns, int rows) {
  int across = (MY(place).width + columns - 1) / columns;
  int line = DIVIDED(number, across);
  int slab = DIVIDED(line, MY(place).height);
  Strip strip;
  strip.left = (number - line * across) * columns;
  strip.y = line - slab * MY(place).height;
  strip.begin = slab * rows;
  strip.end = min(strip.begin + rows, MY(place).depth);
  return strip;
}
#define EACH_STRIP(asked, columns, rows)                                                                     \
  for (int number = item, count = strip_count(WITH_ARRAYS columns, rows); (asked) && number < count;         \
       number += items)
#define EACH_SITE(asked, of)                                                                                 \
  EACH_STRIP(asked, SITE_COLUMNS, SITE_ROWS) {                                                               \
    Strip strip = strip_of(WITH_ARRAYS number, SITE_COLUMNS, SITE_ROWS);                                     \
    for (int row = 0; row < SITE_ROWS; ++row) {                                                              \
      int z = strip.begin + row;                                                                             \
      if (z < strip.end) {                                                                                   \
        SITES_SIDE_BY_SIDE                                                                                   \
        for (int i = 0; i < COUNT(strip.left, SITE_COLUMNS); ++i) {                                          \
          if (IS_THERE(strip.left + i)) {                                                                    \
            Components value = of(WITH_ARRAYS strip.left + i, strip.y, z);                                   \
            STORE(AT(place, strip.left + i, strip.y, z), value)                                              \
          }                                                                                                  \
        }                                                                                                    \
      }                                                                                                      \
    }                                                                                                        \
  }

HDM_FUNCTION void do_step(ARRAYS int item, int items) {
  EACH_STRIP(DOES(ELASTIC_RELAX) || DOES(ELASTIC_RESIDUAL), COLUMNS, ROWS) {
    Strip strip = strip_of(WITH_ARRAYS number, COLUMNS, ROWS);
    sweep_columns(WITH_ARRAYS strip.left, strip.y, strip.begin, strip.end);
  }
  EACH_SITE(DOES(ELASTIC_RELAX_FROM_ZERO), relaxed_from_zero)
  EACH_SITE(DOES(ELASTIC_RESTRICT), restricted_site)
  EACH_SITE(DOES(ELASTIC_INTERPOLATE) || DOES(ELASTIC_CORRECT), corrected_site)
  EACH_SITE(DOES(ELASTIC_SOLVE), solved_site)
#if TOGETHER == 0
  EACH_SITE(DOES(ELASTIC_ADVANCE), advanced_site)
  EACH_SITE(DOES(ELASTIC_PRODUCTS) || DOES(ELASTIC_SQUARES), block_sum)
#endif
}

// The six words of a Place.
HDM_FUNCTION Place place_told(ARRAYS int word) {
  Place of;
  of.width = TOLD(word), of.height = TOLD(word + 1), of.depth = TOLD(word + 2);
  of.first = TOLD(word + 3), of.pitch = TOLD(word + 4), of.layer = TOLD(word + 5);
  return of;
}

// Returns where a level lies, counted from the finest one that is computed together with others.
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
    int code = CODE_TOLD(number);
    int level = code >> 10;
    MY(step) = code & 15;
    MY(from_slot) = code >> 4 & 3;
    MY(second_slot) = code >> 6 & 3;
    MY(stored_slot) = code >> 8 & 3;
    bool from_coarser = DOES(ELASTIC_INTERPOLATE) || DOES(ELASTIC_CORRECT);
    MY(from_place) = place_of(WITH_ARRAYS level);
    MY(second_place) = place_of(WITH_ARRAYS from_coarser ? level + 1 : level);
    MY(place) = place_of(WITH_ARRAYS DOES(ELASTIC_RESTRICT) ? level + 1 : level);
    do_step(WITH_ARRAYS item, items);
    WAIT_FOR_ALL;
    bool sweeps = DOES(ELASTIC_RELAX) || DOES(ELASTIC_RESIDUAL);
    int list = 2 * (TOLD(7) + level);
    do_list(WITH_ARRAYS item, items, TOUCHED(list), sweeps ? TOUCHED(list + 1) : 0);
    WAIT_FOR_ALL;
  }
#endif
}
