#version 430
#extension GL_GOOGLE_include_directive : require

// A step of the elastic energy for all sites of a level: for relax and residual an invocation goes down COLUMNS columns of
// ROWS sites, so that each row is fetched once and what a cell does to its lower corners is kept; for the others an
// invocation has a site. Arrays lie as backends/shared/elastic_device.hpp says.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define HDM_NUMBER(value) float(value)

#include "elastic_steps.h"

// As ElasticKernel has them.
#ifdef VULKAN
#define samplerBuffer textureBuffer
layout(constant_id = 0) const int work = 0;
layout(constant_id = 1) const bool has_load = false;
layout(constant_id = 2) const bool is_image = false;
layout(constant_id = 3) const bool has_masked = false;
layout(push_constant) uniform Parameters { int parameters[13]; };
#else
const int work = STEP;
const bool has_load = HAS_LOAD != 0;
const bool is_image = IS_IMAGE != 0;
const bool has_masked = HAS_MASKED != 0;
layout(location = 0) uniform int parameters[13];
#endif

const int COLUMNS = ELASTIC_COLUMNS;
const int ROWS = ELASTIC_ROWS;
layout(local_size_x = ELASTIC_GROUP) in;

layout(binding = 0) uniform samplerBuffer from;
layout(binding = 1) uniform samplerBuffer second;
layout(binding = 2, rg32f) uniform restrict writeonly imageBuffer stored;
layout(binding = 3) uniform samplerBuffer moments;
layout(binding = 4) uniform samplerBuffer more;
layout(binding = 5) uniform samplerBuffer response;
layout(binding = 6) uniform samplerBuffer matrices; // of ELASTIC_SOLVE the inverse: x and y of a column, a texel a site

#include "elastic/cell.inc"
#include "elastic/site.inc"

const int matrices_across = 64;
vec4 matrix_at(vec2 place, int i) {
  return texelFetch(matrices, (int(place.y) * matrices_across + int(place.x)) * 16 + i);
}

#include "elastic.glsl"

// ElasticParameters.
#define width parameters[0]
#define height parameters[1]
#define first parameters[2]
#define pitch parameters[3]
#define from_first parameters[4]
#define from_pitch parameters[5]
#define from_width parameters[6]
#define from_height parameters[7]
#define second_first parameters[8]
#define second_pitch parameters[9]
#define ratio PoissonRatio(intBitsToFloat(parameters[10]), intBitsToFloat(parameters[11]))
#define factor intBitsToFloat(parameters[12])

vec2 from_at(int i) { return texelFetch(from, i).xy; }
vec2 second_at(int i) { return texelFetch(second, i).xy; }
void store(int i, vec2 value) { imageStore(stored, i, vec4(value, 0.0, 0.0)); }

// The last thing that is done to a site.
void finish_site(int at, int to, vec2 value, Force force) {
  if (has_load) {
    vec2 load = second_at(at);
    force = residual_of(Force(load.x, load.y), force);
  }
  vec2 result = vec2(force.x, force.y);
  if (work == ELASTIC_RELAX) {
    result = relaxed_site(value, texelFetch(response, at), force);
  } else if (is_image) {
    result = free_parts(result, texelFetch(response, at));
  }
  store(to, result);
}

void sweep_columns(int left, int first_row) {
  int end = min(first_row + ROWS, height);
  int at = from_first + (first_row - 1) * from_pitch + left;
  vec2 above[COLUMNS + 2]; // sites left - 1 ... left + COLUMNS of a row
  vec2 below[COLUMNS + 2]; // and of the next
  CellForces cells[COLUMNS + 1]; // between these rows; cell i is to the west of column i
  Force from_west[COLUMNS];      // on the sites of `above`, by the cells above them
  Force from_east[COLUMNS];
  for (int i = 0; i < COLUMNS + 2; ++i) {
    above[i] = from_at(at - 1 + i);
  }
  for (int i = 0; i < COLUMNS; ++i) {
    from_west[i] = null_force();
    from_east[i] = null_force();
  }
  for (int y = first_row - 1; y < end; ++y) {
    for (int i = 0; i < COLUMNS + 2; ++i) {
      below[i] = from_at(at + from_pitch - 1 + i);
    }
    for (int i = 0; i < COLUMNS + 1; ++i) {
      cells[i] = forces_of_cell(texelFetch(moments, at - 1 + i), texelFetch(more, at - 1 + i).xy, above[i],
                                above[i + 1], below[i], below[i + 1], ratio);
    }
    for (int i = 0; i < COLUMNS; ++i) {
      if (y >= first_row && left + i < width) {
        finish_site(at + i, first + y * pitch + left + i, above[i + 1],
                    sum_of_cells(from_west[i], from_east[i], cells[i].top_right, cells[i + 1].top_left));
      }
      from_west[i] = cells[i].bottom_right;
      from_east[i] = cells[i + 1].bottom_left;
    }
    for (int i = 0; i < COLUMNS + 2; ++i) {
      above[i] = below[i];
    }
    at += from_pitch;
  }
}

vec2 fine_at(int i) {
  vec2 value = from_at(i);
  return is_image ? free_parts(value, texelFetch(response, i)) : value;
}
vec2 restricted_row(int at) { return restricted_sites(fine_at(at - 1), fine_at(at), fine_at(at + 1)); }

vec2 corrected_at(int x, int y) {
  int at = from_first + y * from_pitch + x;
  int north_west = second_first + y / 2 * second_pitch + x / 2;
  int south_west = north_west + y % 2 * second_pitch;
  int east = x % 2;
  vec2 value = work == ELASTIC_CORRECT ? from_at(at) : vec2(0.0);
  vec2 corrected = corrected_site(value, x % 2 == 1, y % 2 == 1, second_at(north_west), second_at(north_west + east),
                                  second_at(south_west), second_at(south_west + east));
  if (is_image) {
    vec4 straight = texelFetch(response, at);
    corrected.x = straight.x > 0.0 ? corrected.x : value.x;
    corrected.y = straight.z > 0.0 ? corrected.y : value.y;
  }
  return corrected;
}

vec2 solved_at(int x, int y) {
  int sites = width * height;
  int row = y * width + x;
  vec2 sum = vec2(0.0);
  for (int site = 0; site < sites; ++site) {
    vec2 load = from_at(from_first + site / width * from_pitch + site % width);
    vec2 by_x = texelFetch(matrices, 2 * site * sites + row).xy;
    vec2 by_y = texelFetch(matrices, (2 * site + 1) * sites + row).xy;
    sum = vec2(with_term(sum.x, by_x.x, load.x), with_term(sum.y, by_x.y, load.x));
    sum = vec2(with_term(sum.x, by_y.x, load.y), with_term(sum.y, by_y.y, load.y));
  }
  return sum;
}

// Of what is summed up, 0 beyond its border.
real term_at(int x, int y) {
  if (x >= from_width || y >= from_height) {
    return 0.0;
  }
  vec2 value = from_at(from_first + y * from_pitch + x);
  if (work == ELASTIC_SQUARES) {
    return value.x;
  }
  vec2 other = second_at(second_first + y * second_pitch + x);
  return site_product(value.x, other.x, value.y, other.y);
}
real sum_of_2(int x, int y) {
  return square_sum(term_at(x, y), term_at(x + 1, y), term_at(x, y + 1), term_at(x + 1, y + 1));
}
real sum_of_4(int x, int y) {
  return square_sum(sum_of_2(x, y), sum_of_2(x + 2, y), sum_of_2(x, y + 2), sum_of_2(x + 2, y + 2));
}
real sum_of_8(int x, int y) {
  return square_sum(sum_of_4(x, y), sum_of_4(x + 4, y), sum_of_4(x, y + 4), sum_of_4(x + 4, y + 4));
}

void main() {
  int x = int(gl_GlobalInvocationID.x);
  int y = int(gl_GlobalInvocationID.y);
  if (work == ELASTIC_RELAX || work == ELASTIC_RESIDUAL) {
    if (COLUMNS * x < width) {
      sweep_columns(COLUMNS * x, ROWS * y);
    }
    return;
  }
  if (x >= width) {
    return;
  }
  int at = from_first + y * from_pitch + x; // where from's sites are those of `to`
  vec2 result = vec2(0.0);
  if (work == ELASTIC_RELAX_FROM_ZERO) {
    vec2 load = from_at(at);
    result = relaxed_site(vec2(0.0), texelFetch(response, at), Force(load.x, load.y));
  } else if (work == ELASTIC_RESTRICT) {
    int fine = from_first + 2 * y * from_pitch + 2 * x;
    result = restricted_sites(restricted_row(fine - from_pitch), restricted_row(fine),
                              restricted_row(fine + from_pitch));
  } else if (work == ELASTIC_INTERPOLATE || work == ELASTIC_CORRECT) {
    result = corrected_at(x, y);
  } else if (work == ELASTIC_SOLVE) {
    result = solved_at(x, y);
  } else if (work == ELASTIC_ADVANCE) {
    vec2 value = from_at(at);
    vec2 direction = second_at(at);
    result = vec2(advanced(value.x, factor, direction.x), advanced(value.y, factor, direction.y));
  } else {
    result = vec2(sum_of_8(8 * x, 8 * y), 0.0);
  }
  store(first + y * pitch + x, result);
}
