// A step of the elastic energy for all sites of a level as OpenCL C 1.2, a group for each row. The host
// supplies STEP, HAS_LOAD, IS_IMAGE and HAS_MASKED (backends/session/elastic_steps.hpp, ElasticKernel) and LANES as
// sweep.cl has it.
//
// Arrays over sites and cells are planes of one number each, as ElasticLayout says.

#include "language.cl"
#include "elastic_steps.h"
#include "elastic/cell.inc"
#include "elastic/site.inc"

// 16: PoCL takes 8 of its own accord.
#if defined(__clang__) && LANES == 1
#define SITES_SIDE_BY_SIDE _Pragma("clang loop vectorize(assume_safety) vectorize_width(16)")
#else
#define SITES_SIDE_BY_SIDE
#endif

// ElasticParameters of backends/session/elastic_steps.hpp.
typedef struct {
  int width;
  int height;
  int first;
  int pitch;
  int from_first;
  int from_pitch;
  int from_width;
  int from_height;
  int second_first;
  int second_pitch;
  int listed_first; // where the level begins in row_begin
  int listed;       // not used here
  float nu;
  float shear;
  float factor;
  int plane; // from a plane to the next
} Parameters;

// x and y of the sites of a level.
typedef struct {
  global const float* x;
  global const float* y;
} Field;

HDM_FUNCTION Force pair_at(Field field, int at) {
  return force_of(field.x[at], field.y[at]);
}

// What does not change of a level.
typedef struct {
  global const float* moments;
  global const float* response;
  global const float* matrices; // of masked cells, 64 numbers each, column by column
  size_t plane;
} Fixed;

HDM_FUNCTION CellCorners corners_at(global const float* values, int at, int pitch) {
  CellCorners corners = {values[at], values[at + 1], values[at + pitch], values[at + pitch + 1]};
  return corners;
}

HDM_FUNCTION CellTension tension_at(Field from, Fixed fixed, int at, Parameters p) {
  global const float* moments = fixed.moments + at;
  size_t plane = fixed.plane;
  CellMoments cell = {moments[0], moments[plane], moments[2 * plane], moments[3 * plane], moments[4 * plane],
                      moments[5 * plane]};
  PoissonRatio ratio = {p.nu, p.shear};
  return cell_tension(cell, corners_at(from.x, at, p.from_pitch), corners_at(from.y, at, p.from_pitch), ratio);
}

HDM_FUNCTION Force force_on_site(Field from, Fixed fixed, int at, Parameters p) {
  int north = at - p.from_pitch;
  return sum_of_cells(force_on_bottom_right(tension_at(from, fixed, north - 1, p)),
                      force_on_bottom_left(tension_at(from, fixed, north, p)),
                      force_on_top_right(tension_at(from, fixed, at - 1, p)),
                      force_on_top_left(tension_at(from, fixed, at, p)));
}

// What cell `at` does to a corner, 0 ... 3 in reading order; `masked` is the number of its matrix, -1 where it has moments.
HDM_FUNCTION Force force_of_cell(Field from, Fixed fixed, int at, int corner, int masked, Parameters p) {
  if (masked >= 0) {
    CellCorners dx = corners_at(from.x, at, p.from_pitch);
    CellCorners dy = corners_at(from.y, at, p.from_pitch);
    float values[8] = {dx.top_left, dy.top_left, dx.top_right, dy.top_right,
                       dx.bottom_left, dy.bottom_left, dx.bottom_right, dy.bottom_right};
    global const float* stiffness = fixed.matrices + 64 * (size_t)masked + 2 * corner;
    Force force = force_of(0.0f, 0.0f);
    for (int column = 0; column < 8; ++column) {
      force.x = masked_force(force.x, stiffness[8 * column], values[column]);
      force.y = masked_force(force.y, stiffness[8 * column + 1], values[column]);
    }
    return force;
  }
  CellTension tension = tension_at(from, fixed, at, p);
  return corner == 0   ? force_on_top_left(tension)
         : corner == 1 ? force_on_top_right(tension)
         : corner == 2 ? force_on_bottom_left(tension)
                       : force_on_bottom_right(tension);
}

HDM_FUNCTION Force relaxed_site(Force value, Fixed fixed, int at, Force residual) {
  global const float* response = fixed.response + at; // xx, xy, yy
  float across = response[fixed.plane];
  return force_of(relaxed(value.x, response[0], residual.x, across, residual.y),
                  relaxed(value.y, response[2 * fixed.plane], residual.y, across, residual.x));
}

HDM_FUNCTION void store(global float* to, size_t plane, int at, Force value) {
  to[at] = value.x;
  to[plane + at] = value.y;
}

// The last thing that is done to a site.
HDM_FUNCTION void finish_site(Field from, Field load, global float* to, Fixed fixed, int at, Force force) {
#if HAS_LOAD
  force = residual_of(pair_at(load, at), force);
#endif
#if STEP == ELASTIC_RELAX
  force = relaxed_site(pair_at(from, at), fixed, at, force);
#elif IS_IMAGE
  force.x = free_part(force.x, fixed.response[at]);
  force.y = free_part(force.y, fixed.response[2 * fixed.plane + at]);
#endif
  store(to, fixed.plane, at, force);
}

// A site beside masked cells, and the numbers of the matrices of its cells in reading order.
typedef struct {
  int x;
  int y;
  int masked[4];
} TouchedSite;

// f: `from`, s: `second` of ElasticStep.
kernel void elastic_step(global const float* restrict f, global const float* restrict s, global float* restrict to,
                 global const float* restrict moments, global const float* restrict response,
                 global const TouchedSite* restrict touched, global const int* restrict row_begin,
                 global const float* restrict matrices, global const float* restrict inverse, Parameters p) {
  size_t plane = p.plane;
  int y = get_group_id(0);
  int lane = get_local_id(0);
  Field from = {f, f + plane};
  Field second = {s, s + plane};
  Fixed fixed = {moments, response, matrices, plane};

#if STEP == ELASTIC_RELAX || STEP == ELASTIC_RESIDUAL
  int start = p.from_first + y * p.from_pitch;
  SITES_SIDE_BY_SIDE
  for (int x = lane; x < p.width; x += LANES) {
    int at = start + x;
    finish_site(from, second, to, fixed, at, force_on_site(from, fixed, at, p));
  }
#if HAS_MASKED
  barrier(CLK_GLOBAL_MEM_FENCE);
  for (int i = row_begin[p.listed_first + y] + lane; i < row_begin[p.listed_first + y + 1]; i += LANES) {
    TouchedSite site = touched[i];
    int at = start + site.x;
    int north = at - p.from_pitch;
    Force force = sum_of_cells(force_of_cell(from, fixed, north - 1, 3, site.masked[0], p),
                               force_of_cell(from, fixed, north, 2, site.masked[1], p),
                               force_of_cell(from, fixed, at - 1, 1, site.masked[2], p),
                               force_of_cell(from, fixed, at, 0, site.masked[3], p));
    finish_site(from, second, to, fixed, at, force);
  }
#endif

#elif STEP == ELASTIC_RELAX_FROM_ZERO
  int start = p.from_first + y * p.from_pitch;
  SITES_SIDE_BY_SIDE
  for (int x = lane; x < p.width; x += LANES) {
    int at = start + x;
    store(to, plane, at, relaxed_site(force_of(0.0f, 0.0f), fixed, at, pair_at(from, at)));
  }

#elif STEP == ELASTIC_RESTRICT
  int start = p.from_first + 2 * y * p.from_pitch;
  for (int number = 0; number < 2; ++number) {
    global const float* values = f + number * plane;
    global const float* straight = response + 2 * number * plane;
    global float* store = to + number * plane + p.first + y * p.pitch;
#if IS_IMAGE
#define VALUE(i) free_part(values[i], straight[i])
#else
#define VALUE(i) values[i]
#endif
#define ROW(i) restricted(VALUE((i) - 1), VALUE(i), VALUE((i) + 1))
    SITES_SIDE_BY_SIDE
    for (int x = lane; x < p.width; x += LANES) {
      int at = start + 2 * x;
      store[x] = restricted(ROW(at - p.from_pitch), ROW(at), ROW(at + p.from_pitch));
    }
  }

#elif STEP == ELASTIC_INTERPOLATE || STEP == ELASTIC_CORRECT
  int start = p.from_first + y * p.from_pitch;
  int north = p.second_first + y / 2 * p.second_pitch;
  int south = p.second_first + (y / 2 + y % 2) * p.second_pitch;
  for (int number = 0; number < 2; ++number) {
    global const float* values = f + number * plane + start;
    global const float* coarse = s + number * plane;
    global const float* straight = response + 2 * number * plane + start;
    global float* store = to + number * plane + start;
    SITES_SIDE_BY_SIDE
    for (int x = lane; x < p.width; x += LANES) {
      int west = x / 2;
      int east = x / 2 + x % 2;
      float value = STEP == ELASTIC_CORRECT ? values[x] : 0.0f;
      float at_site = corrected_by_one(value, coarse[north + west]);
      float between = corrected_by_two(value, coarse[north + west], coarse[south + east]);
      float amid = corrected_by_four(value, coarse[north + west], coarse[north + east], coarse[south + west],
                                     coarse[south + east]);
      float corrected = x % 2 + y % 2 == 0 ? at_site : x % 2 + y % 2 == 1 ? between : amid;
#if IS_IMAGE
      corrected = straight[x] > 0.0f ? corrected : value;
#endif
      store[x] = corrected;
    }
  }

#elif STEP == ELASTIC_SOLVE
  // Columns of the inverse go with the sites of the level and their components.
  int rows = 2 * p.width * p.height;
  for (int x = lane; x < p.width; x += LANES) {
    int row = 2 * (y * p.width + x);
    float sum_x = 0.0f;
    float sum_y = 0.0f;
    for (int site = 0; site < p.width * p.height; ++site) {
      int at = p.from_first + site / p.width * p.from_pitch + site % p.width;
      global const float* column = inverse + 2 * site * rows + row;
      sum_x = with_term(sum_x, column[0], from.x[at]);
      sum_y = with_term(sum_y, column[1], from.x[at]);
      sum_x = with_term(sum_x, column[rows], from.y[at]);
      sum_y = with_term(sum_y, column[rows + 1], from.y[at]);
    }
    int at = p.first + y * p.pitch + x;
    to[at] = sum_x;
    to[plane + at] = sum_y;
  }

#elif STEP == ELASTIC_ADVANCE
  int start = p.from_first + y * p.from_pitch;
  SITES_SIDE_BY_SIDE
  for (int x = lane; x < p.width; x += LANES) {
    int at = start + x;
    to[at] = advanced(from.x[at], p.factor, second.x[at]);
    to[plane + at] = advanced(from.y[at], p.factor, second.y[at]);
  }

#else
  // Blocks of 8 x 8, each a tree of 2 x 2 squares.
  for (int x = lane; x < p.width; x += LANES) {
    float sums[64];
    for (int j = 0; j < 8; ++j) {
      for (int i = 0; i < 8; ++i) {
        int column = 8 * x + i;
        int row = 8 * y + j;
        bool inside = column < p.from_width && row < p.from_height;
        int at = p.from_first + row * p.from_pitch + column;
#if STEP == ELASTIC_PRODUCTS
        sums[8 * j + i] = inside ? site_product(from.x[at], second.x[at], from.y[at], second.y[at]) : 0.0f;
#else
        sums[8 * j + i] = inside ? f[at] : 0.0f;
#endif
      }
    }
    for (int side = 4; side > 0; side /= 2) {
      for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
          sums[8 * j + i] = square_sum(sums[16 * j + 2 * i], sums[16 * j + 2 * i + 1], sums[16 * j + 8 + 2 * i],
                                       sums[16 * j + 8 + 2 * i + 1]);
        }
      }
    }
    to[p.first + y * p.pitch + x] = sums[0];
  }
#endif
}
