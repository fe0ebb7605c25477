#version 430
#extension GL_GOOGLE_include_directive : require

// A step of the elastic energy for all sites of a level: an invocation goes down ROWS sites, of COLUMNS columns for relax
// and residual, so that each row is fetched once and what a cell does to its lower corners is kept, of two where a coarser
// level is interpolated, and of one for the others. Or, of relax and residual, for the sites of a list, those beside masked
// cells.

#include "elastic_arrays.glsl"

#ifdef VULKAN
layout(constant_id = 0) const int work = 0;
layout(constant_id = 1) const bool has_load = false;
layout(constant_id = 2) const bool is_image = false;
layout(constant_id = 3) const bool by_list = false;
layout(local_size_x_id = 4) in;
layout(constant_id = 5) const int ROWS = 1;
const int LANES = int(gl_WorkGroupSize.x);
layout(push_constant) uniform Parameters { int parameters[16]; };
#else // supplied after #version
const int work = STEP;
const bool has_load = HAS_LOAD != 0;
const bool is_image = IS_IMAGE != 0;
const bool by_list = BY_LIST != 0;
layout(local_size_x = LANES) in;
layout(location = 0) uniform int parameters[16];
#endif
const int base = 0;

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
#define listed_first parameters[10]
#define listed parameters[11]
#define ratio PoissonRatio(intBitsToFloat(parameters[12]), intBitsToFloat(parameters[13]))
#define factor intBitsToFloat(parameters[14])

vec2 from_at(int i) { return texelFetch(from, i).xy; }
vec2 second_at(int i) { return texelFetch(second, i).xy; }
void store(int i, vec2 value) { imageStore(stored, i, vec4(value, 0.0, 0.0)); }

#include "elastic_sites.glsl"

// Of what is summed up, 0 beyond its border. Without a branch: there are 64 of these in a row, and a compiler that looks
// for paths through them doubles its search with each.
real term_at(int x, int y) {
  ivec2 last = ivec2(from_width - 1, from_height - 1);
  ivec2 at = min(ivec2(x, y), last);
  vec2 value = from_at(from_first + at.y * from_pitch + at.x);
  real term = value.x;
  if (work != ELASTIC_SQUARES) {
    vec2 other = second_at(second_first + at.y * second_pitch + at.x);
    term = site_product(value.x, other.x, value.y, other.y);
  }
  bool inside = all(equal(at, ivec2(x, y)));
  real none = 0.0;
  return inside ? term : none;
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

vec2 result_at(int x, int y) {
  int at = from_first + y * from_pitch + x; // where from's sites are those of `to`
  if (work == ELASTIC_RELAX_FROM_ZERO) {
    return relaxed_from_zero(at);
  }
  if (work == ELASTIC_RESTRICT) {
    return restricted_at(x, y);
  }
  if (work == ELASTIC_SOLVE) {
    return solved_at(x, y);
  }
  if (work == ELASTIC_ADVANCE) {
    vec2 value = from_at(at);
    vec2 direction = second_at(at);
    return vec2(advanced(value.x, factor, direction.x), advanced(value.y, factor, direction.y));
  }
  return vec2(sum_of_8(8 * x, 8 * y), 0.0);
}

void main() {
  int x = int(gl_GlobalInvocationID.x);
  int first_row = ROWS * int(gl_WorkGroupID.y);
  int end = min(first_row + ROWS, height);
  if (by_list) {
    int number = int(gl_WorkGroupID.y) * ELASTIC_LIST_GROUPS * LANES + x;
    if (number < listed) {
      ivec2 site = ivec2(texelFetch(touched, listed_first + number).xy);
      sweep_listed(site.x, site.y);
    }
  } else if (work == ELASTIC_RELAX || work == ELASTIC_RESIDUAL) {
    if (COLUMNS * x < width) {
      sweep_columns(COLUMNS * x, first_row, end);
    }
  } else if (work == ELASTIC_INTERPOLATE || work == ELASTIC_CORRECT) {
    if (2 * x < width) {
      for (int y = first_row; y < end; y += 2) {
        correct_block(2 * x, y);
      }
    }
  } else if (x < width) {
    for (int y = first_row; y < end; ++y) {
      store(first + y * pitch + x, result_at(x, y));
    }
  }
}
