// What is done to sites of a level, for compute shaders on buffers: arrays lie as backends/shared/elastic_device.hpp says.
// Compiled after elastic.glsl; the includer supplies
//
//   work, has_load, is_image       the step and the rest of ElasticKernel
//   width ... ratio                ElasticParameters
//   from_at(i), second_at(i)       vec2: a site's x and y
//   store(i, value)
//   moments_at(i), more_at(i), response_at(i)  vec4: ElasticTexels
//   inverse                        ElasticHierarchy::coarsest_inverse: x and y of a column, a texel a site
//   COLUMNS                        constant

// The last thing that is done to a site.
void finish_site(int at, int to, vec2 value, Force force) {
  if (has_load) {
    vec2 load = second_at(at);
    force = residual_of(Force(load.x, load.y), force);
  }
  vec2 result = vec2(force.x, force.y);
  if (work == ELASTIC_RELAX) {
    result = relaxed_site(value, response_at(at), force);
  } else if (is_image) {
    result = free_parts(result, response_at(at));
  }
  store(to, result);
}

// Sites left ... left + COLUMNS - 1 of rows first_row ... end - 1.
void sweep_columns(int left, int first_row, int end) {
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
      cells[i] = forces_of_cell(false, moments_at(at - 1 + i), more_at(at - 1 + i), above[i], above[i + 1], below[i], below[i + 1], ratio);
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

// One of the cells that lie beside a site; `at` is its place.
CellForces forces_of_listed(int at) {
  return forces_of_cell(true, moments_at(at), more_at(at), from_at(at), from_at(at + 1), from_at(at + from_pitch),
                        from_at(at + from_pitch + 1), ratio);
}

// A site beside masked cells.
void sweep_listed(int x, int y) {
  int at = from_first + y * from_pitch + x;
  int north = at - from_pitch;
  Force force = sum_of_cells(forces_of_listed(north - 1).bottom_right, forces_of_listed(north).bottom_left,
                             forces_of_listed(at - 1).top_right, forces_of_listed(at).top_left);
  finish_site(at, first + y * pitch + x, from_at(at), force);
}

vec2 relaxed_from_zero(int at) {
  vec2 load = from_at(at);
  return relaxed_site(vec2(0.0), response_at(at), Force(load.x, load.y));
}

vec2 fine_at(int i) {
  vec2 value = from_at(i);
  return is_image ? free_parts(value, response_at(i)) : value;
}
vec2 restricted_row(int at) { return restricted_sites(fine_at(at - 1), fine_at(at), fine_at(at + 1)); }

vec2 restricted_at(int x, int y) {
  int fine = from_first + 2 * y * from_pitch + 2 * x;
  return restricted_sites(restricted_row(fine - from_pitch), restricted_row(fine), restricted_row(fine + from_pitch));
}

vec2 corrected_at(int x, int y) {
  int at = from_first + y * from_pitch + x;
  int north_west = second_first + y / 2 * second_pitch + x / 2;
  int south_west = north_west + y % 2 * second_pitch;
  int east = x % 2;
  vec2 value = work == ELASTIC_CORRECT ? from_at(at) : vec2(0.0);
  vec2 corrected = corrected_site(value, x % 2 == 1, y % 2 == 1, second_at(north_west), second_at(north_west + east),
                                  second_at(south_west), second_at(south_west + east));
  if (is_image) {
    vec4 straight = response_at(at);
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
    vec2 by_x = texelFetch(inverse, 2 * site * sites + row).xy;
    vec2 by_y = texelFetch(inverse, (2 * site + 1) * sites + row).xy;
    sum = vec2(with_term(sum.x, by_x.x, load.x), with_term(sum.y, by_x.y, load.x));
    sum = vec2(with_term(sum.x, by_y.x, load.y), with_term(sum.y, by_y.y, load.y));
  }
  return sum;
}
