// A step of the elastic energy for all sites of a level as OpenCL C 1.2, a group for each row. Compiled after language.cl,
// elastic_steps.h, cell.inc and site.inc of the elastic energy. The host supplies STEP, HAS_LOAD, IS_IMAGE and HAS_MASKED
// (backends/shared/elastic_device.hpp, ElasticKernel) and LANES as sweep.cl has them.
//
// Arrays over sites and cells are planes of one number each, as ElasticLayout says.

#undef for

// 16: PoCL takes 8 of its own accord.
#if defined(__clang__) && LANES == 1
#define SITES_SIDE_BY_SIDE _Pragma("clang loop vectorize(assume_safety) vectorize_width(16)")
#else
#define SITES_SIDE_BY_SIDE
#endif

// ElasticParameters of backends/shared/elastic_device.hpp.
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

typedef struct {
  global const float* x;
  global const float* y;
} Field;

HDM_FUNCTION Field field_at(global const float* planes, uint plane) {
  Field field;
  field.x = planes;
  field.y = planes + plane;
  return field;
}

HDM_FUNCTION CellCorners corners_at(global const float* values, int at, int pitch) {
  CellCorners corners;
  corners.top_left = values[at];
  corners.top_right = values[at + 1];
  corners.bottom_left = values[at + pitch];
  corners.bottom_right = values[at + pitch + 1];
  return corners;
}

HDM_FUNCTION CellTension tension_at(Field from, global const float* moments, size_t plane, int at, Parameters p) {
  CellMoments cell;
  cell.m = moments[at];
  cell.mr = moments[plane + at];
  cell.ms = moments[2 * plane + at];
  cell.mrr = moments[3 * plane + at];
  cell.mss = moments[4 * plane + at];
  cell.mrs = moments[5 * plane + at];
  PoissonRatio ratio;
  ratio.nu = p.nu;
  ratio.shear = p.shear;
  return cell_tension(cell, corners_at(from.x, at, p.from_pitch), corners_at(from.y, at, p.from_pitch), ratio);
}

HDM_FUNCTION Force force_on_site(Field from, global const float* moments, size_t plane, int at, Parameters p) {
  int north = at - p.from_pitch;
  return sum_of_cells(force_on_bottom_right(tension_at(from, moments, plane, north - 1, p)),
                      force_on_bottom_left(tension_at(from, moments, plane, north, p)),
                      force_on_top_right(tension_at(from, moments, plane, at - 1, p)),
                      force_on_top_left(tension_at(from, moments, plane, at, p)));
}

// Of a masked cell, 64 numbers column by column, on corner 0 ... 3 in reading order.
HDM_FUNCTION Force force_of_masked(global const float* stiffness, int corner, CellCorners dx, CellCorners dy) {
  float values[8] = {dx.top_left, dy.top_left, dx.top_right, dy.top_right,
                     dx.bottom_left, dy.bottom_left, dx.bottom_right, dy.bottom_right};
  Force force;
  force.x = 0.0f;
  force.y = 0.0f;
  for (int column = 0; column < 8; ++column) {
    force.x = masked_force(force.x, stiffness[8 * column + 2 * corner], values[column]);
    force.y = masked_force(force.y, stiffness[8 * column + 2 * corner + 1], values[column]);
  }
  return force;
}

// What cell `at` does to a corner; `masked` is the number of its matrix, -1 where it has moments.
HDM_FUNCTION Force force_of_cell(Field from, global const float* moments, size_t plane, int at, int corner, int masked,
                                 global const float* matrices, Parameters p) {
  if (masked >= 0) {
    return force_of_masked(matrices + 64 * (size_t)masked, corner, corners_at(from.x, at, p.from_pitch),
                           corners_at(from.y, at, p.from_pitch));
  }
  CellTension tension = tension_at(from, moments, plane, at, p);
  return corner == 0   ? force_on_top_left(tension)
         : corner == 1 ? force_on_top_right(tension)
         : corner == 2 ? force_on_bottom_left(tension)
                       : force_on_bottom_right(tension);
}

// The last thing that is done to a site.
HDM_FUNCTION void finish_site(Field from, Field load, global float* to, global const float* response, size_t plane, int at,
                              Force force) {
#if HAS_LOAD
  Force loaded;
  loaded.x = load.x[at];
  loaded.y = load.y[at];
  force = residual_of(loaded, force);
#endif
#if STEP == ELASTIC_RELAX
  float x = relaxed(from.x[at], response[at], force.x, response[plane + at], force.y);
  float y = relaxed(from.y[at], response[2 * plane + at], force.y, response[plane + at], force.x);
#elif IS_IMAGE
  float x = free_part(force.x, response[at]);
  float y = free_part(force.y, response[2 * plane + at]);
#else
  float x = force.x;
  float y = force.y;
#endif
  to[at] = x;
  to[plane + at] = y;
}

// A site beside masked cells: its column, and the numbers of the matrices of its cells in reading order.
typedef struct {
  int x;
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
  Field from = field_at(f, p.plane);
  Field second = field_at(s, p.plane);

#if STEP == ELASTIC_RELAX || STEP == ELASTIC_RESIDUAL
  int start = p.from_first + y * p.from_pitch;
  SITES_SIDE_BY_SIDE
  for (int x = lane; x < p.width; x += LANES) {
    int at = start + x;
    finish_site(from, second, to, response, plane, at, force_on_site(from, moments, plane, at, p));
  }
#if HAS_MASKED
  barrier(CLK_GLOBAL_MEM_FENCE);
  for (int i = row_begin[p.listed_first + y] + lane; i < row_begin[p.listed_first + y + 1]; i += LANES) {
    TouchedSite site = touched[i];
    int at = start + site.x;
    int north = at - p.from_pitch;
    Force force = sum_of_cells(force_of_cell(from, moments, plane, north - 1, 3, site.masked[0], matrices, p),
                               force_of_cell(from, moments, plane, north, 2, site.masked[1], matrices, p),
                               force_of_cell(from, moments, plane, at - 1, 1, site.masked[2], matrices, p),
                               force_of_cell(from, moments, plane, at, 0, site.masked[3], matrices, p));
    finish_site(from, second, to, response, plane, at, force);
  }
#endif

#elif STEP == ELASTIC_RELAX_FROM_ZERO
  int start = p.from_first + y * p.from_pitch;
  SITES_SIDE_BY_SIDE
  for (int x = lane; x < p.width; x += LANES) {
    int at = start + x;
    float load_x = from.x[at];
    float load_y = from.y[at];
    to[at] = relaxed(0.0f, response[at], load_x, response[plane + at], load_y);
    to[plane + at] = relaxed(0.0f, response[2 * plane + at], load_y, response[plane + at], load_x);
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
