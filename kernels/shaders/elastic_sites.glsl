// What compute shaders do to sites of a level. Compiled after elastic_arrays.glsl; the includer supplies
//
//   work, has_load, is_image       the step and the rest of ElasticKernel
//   width ... ratio                ElasticParameters
//   from_at(i), second_at(i)       vec2: a site's x and y
//   store(i, value)
//   base                           where the levels begin in what does not change (elastic_arrays.glsl)

// ElasticTexels.
vec4 moments_at(int i) { return texelFetch(moments, base + i); }
vec4 more_at(int i) { return texelFetch(more, base + i); }
vec4 response_at(int i) { return texelFetch(response, base + i); }

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
    from_west[i] = Force(0.0, 0.0);
    from_east[i] = Force(0.0, 0.0);
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

// What the cell at `at` does to its corner 0 ... 3 in reading order, if it is masked; else `otherwise`. No branch:
// rasterizers on the CPU execute both sides. Displacements of the corners in reading order.
Force masked_or(Force otherwise, float number, int corner, vec2 top_left, vec2 top_right, vec2 bottom_left,
                vec2 bottom_right) {
  HDM_PRECISE float before = number - 1.0;
  float found = max(before, 0.0);
  Force force = more_masked_force(Force(0.0, 0.0), matrix_at(found, 4 * corner), top_left);
  force = more_masked_force(force, matrix_at(found, 4 * corner + 1), top_right);
  force = more_masked_force(force, matrix_at(found, 4 * corner + 2), bottom_left);
  force = more_masked_force(force, matrix_at(found, 4 * corner + 3), bottom_right);
  return Force(number > 0.0 ? force.x : otherwise.x, number > 0.0 ? force.y : otherwise.y);
}

CellForces forces_of_listed(int at, vec4 rest, vec2 top_left, vec2 top_right, vec2 bottom_left, vec2 bottom_right) {
  return forces_of_cell(false, moments_at(at), rest, top_left, top_right, bottom_left, bottom_right, ratio);
}

// A site beside masked cells.
void sweep_listed(int x, int y) {
  int at = from_first + y * from_pitch + x;
  int above = at - from_pitch;
  vec2 north_west = from_at(above - 1);
  vec2 north = from_at(above);
  vec2 north_east = from_at(above + 1);
  vec2 west = from_at(at - 1);
  vec2 centre = from_at(at);
  vec2 east = from_at(at + 1);
  vec2 south_west = from_at(at + from_pitch - 1);
  vec2 south = from_at(at + from_pitch);
  vec2 south_east = from_at(at + from_pitch + 1);
  vec4 rest_nw = more_at(above - 1); // of the four cells
  vec4 rest_ne = more_at(above);
  vec4 rest_sw = more_at(at - 1);
  vec4 rest_se = more_at(at);
  Force of_nw = forces_of_listed(above - 1, rest_nw, north_west, north, west, centre).bottom_right;
  Force of_ne = forces_of_listed(above, rest_ne, north, north_east, centre, east).bottom_left;
  Force of_sw = forces_of_listed(at - 1, rest_sw, west, centre, south_west, south).top_right;
  Force of_se = forces_of_listed(at, rest_se, centre, east, south, south_east).top_left;
  finish_site(at, first + y * pitch + x, centre,
              sum_of_cells(masked_or(of_nw, rest_nw.z, 3, north_west, north, west, centre),
                           masked_or(of_ne, rest_ne.z, 2, north, north_east, centre, east),
                           masked_or(of_sw, rest_sw.z, 1, west, centre, south_west, south),
                           masked_or(of_se, rest_se.z, 0, centre, east, south, south_east)));
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

vec2 value_to_correct(int at) { return work == ELASTIC_CORRECT ? from_at(at) : vec2(0.0); }

void store_corrected(int x, int y, int at, vec2 value, vec2 corrected) {
  if (x < width && y < height) {
    if (is_image) {
      vec4 straight = response_at(at);
      corrected.x = straight.x > 0.0 ? corrected.x : value.x;
      corrected.y = straight.z > 0.0 ? corrected.y : value.y;
    }
    store(first + y * pitch + x, corrected);
  }
}

// The four sites x, y ... x + 1, y + 1 between four coarse ones; x and y are even.
void correct_block(int x, int y) {
  int at = from_first + y * from_pitch + x;
  int coarse = second_first + y / 2 * second_pitch + x / 2;
  vec2 nw = second_at(coarse);
  vec2 ne = second_at(coarse + 1);
  vec2 sw = second_at(coarse + second_pitch);
  vec2 se = second_at(coarse + second_pitch + 1);
  vec2 value = value_to_correct(at);
  store_corrected(x, y, at, value, vec2(corrected_by_one(value.x, nw.x), corrected_by_one(value.y, nw.y)));
  value = value_to_correct(at + 1);
  store_corrected(x + 1, y, at + 1, value,
                  vec2(corrected_by_two(value.x, nw.x, ne.x), corrected_by_two(value.y, nw.y, ne.y)));
  at += from_pitch;
  value = value_to_correct(at);
  store_corrected(x, y + 1, at, value,
                  vec2(corrected_by_two(value.x, nw.x, sw.x), corrected_by_two(value.y, nw.y, sw.y)));
  value = value_to_correct(at + 1);
  store_corrected(x + 1, y + 1, at + 1, value,
                  vec2(corrected_by_four(value.x, nw.x, ne.x, sw.x, se.x),
                       corrected_by_four(value.y, nw.y, ne.y, sw.y, se.y)));
}

// By ElasticHierarchy::coarsest_inverse: x and y of a column, a texel a site.
vec2 solved_at(int x, int y) {
  int sites = width * height;
  int coefficient = y * width + x;
  vec2 sum = vec2(0.0);
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      vec2 load = from_at(from_first + j * from_pitch + i);
      vec2 by_x = texelFetch(inverse, coefficient).xy;
      vec2 by_y = texelFetch(inverse, coefficient + sites).xy;
      sum = vec2(with_term(sum.x, by_x.x, load.x), with_term(sum.y, by_x.y, load.x));
      sum = vec2(with_term(sum.x, by_y.x, load.y), with_term(sum.y, by_y.y, load.y));
      coefficient += 2 * sites;
    }
  }
  return sum;
}
