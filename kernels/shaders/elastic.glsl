// What the steps of the elastic energy need of an image (elastic.frag).

#include "elastic/cell.inc"

vec4 level_at(sampler2DRect texels, vec2 p) { return texture2DRect(texels, p); }
vec2 site_drawn() { return gl_FragCoord.xy; }
vec2 straight_at(vec2 p) { return level_at(response[0], p).xz; }

// Texel i of the matrix of a masked cell (elastic_matrices()): rows of 64 cells.
vec4 matrix_at(float number, int i) {
  float row = floor(number / 64.0);
  return texture2DRect(matrices, vec2(16.0 * (number - 64.0 * row) + float(i), row) + 0.5);
}

// Of a cell on its corners.
struct CellForces {
  Force top_left, top_right;
  Force bottom_left, bottom_right;
};

// The next two terms of the force of a masked cell on a corner that is moved so. `stiffness`: a texel of its matrix.
Force more_masked_force(Force force, vec4 stiffness, vec2 moved) {
  force.x = masked_force(force.x, stiffness.x, moved.x);
  force.y = masked_force(force.y, stiffness.y, moved.x);
  force.x = masked_force(force.x, stiffness.z, moved.y);
  force.y = masked_force(force.y, stiffness.w, moved.y);
  return force;
}

// Displacements of the corners in reading order.
CellForces forces_of_cell(vec2 p, vec2 top_left, vec2 top_right, vec2 bottom_left, vec2 bottom_right) {
  vec4 first = level_at(moments[0], p);
  vec4 more = level_at(moments[1], p);
  Law law = Law(law_told.x, law_told.y, law_told.z);
  CellTension tension = cell_tension(CellMoments(first.x, first.y, first.z, first.w, more.x, more.y),
                                     CellCorners(top_left.x, top_right.x, bottom_left.x, bottom_right.x),
                                     CellCorners(top_left.y, top_right.y, bottom_left.y, bottom_right.y),
                                     law);
  CellForces forces = CellForces(force_on_top_left(tension, law), force_on_top_right(tension, law),
                                 force_on_bottom_left(tension, law), force_on_bottom_right(tension, law));
#if HAS_MASKED
  // A loop, not a branch: rasterizers on the CPU execute both sides of a branch, but leave a loop when all are done.
  float number = level_at(response[0], p).w - 1.0;
  int corner = number >= 0.0 ? 0 : 4;
  if (corner == 0) {
    forces = CellForces(Force(0.0, 0.0), Force(0.0, 0.0), Force(0.0, 0.0), Force(0.0, 0.0));
  }
  for (; corner < 4; ++corner) {
    vec2 moved = corner < 2 ? (corner == 0 ? top_left : top_right) : (corner == 2 ? bottom_left : bottom_right);
    forces.top_left = more_masked_force(forces.top_left, matrix_at(number, corner), moved);
    forces.top_right = more_masked_force(forces.top_right, matrix_at(number, 4 + corner), moved);
    forces.bottom_left = more_masked_force(forces.bottom_left, matrix_at(number, 8 + corner), moved);
    forces.bottom_right = more_masked_force(forces.bottom_right, matrix_at(number, 12 + corner), moved);
  }
#endif
  return forces;
}

vec2 force_at(vec2 p) {
  vec2 north_west = level_at(from, p + vec2(-1.0, -1.0)).xy;
  vec2 north = level_at(from, p + vec2(0.0, -1.0)).xy;
  vec2 north_east = level_at(from, p + vec2(1.0, -1.0)).xy;
  vec2 west = level_at(from, p + vec2(-1.0, 0.0)).xy;
  vec2 centre = level_at(from, p).xy;
  vec2 east = level_at(from, p + vec2(1.0, 0.0)).xy;
  vec2 south_west = level_at(from, p + vec2(-1.0, 1.0)).xy;
  vec2 south = level_at(from, p + vec2(0.0, 1.0)).xy;
  vec2 south_east = level_at(from, p + vec2(1.0, 1.0)).xy;
  Force force = sum_of_cells(forces_of_cell(p + vec2(-1.0, -1.0), north_west, north, west, centre).bottom_right,
                             forces_of_cell(p + vec2(0.0, -1.0), north, north_east, centre, east).bottom_left,
                             forces_of_cell(p + vec2(-1.0, 0.0), west, centre, south_west, south).top_right,
                             forces_of_cell(p, centre, east, south, south_east).top_left);
  return vec2(force.x, force.y);
}

vec2 relaxed_site(vec2 displacement, vec2 p, vec2 residual) {
  vec4 entries = level_at(response[0], p);
  return vec2(relaxed(displacement.x, entries.x, residual.x, entries.y, residual.y),
              relaxed(displacement.y, entries.z, residual.y, entries.y, residual.x));
}

// By the coarse sites around, two or four of which may be one; `odd`: 0 or 1. The first one is at p.
vec2 corrected_site(vec2 value, vec2 odd, vec2 p) {
  vec2 north_west = texture2DRect(second, p).xy;
  vec2 north_east = texture2DRect(second, p + vec2(odd.x, 0.0)).xy;
  vec2 south_west = texture2DRect(second, p + vec2(0.0, odd.y)).xy;
  vec2 south_east = texture2DRect(second, p + odd).xy;
  vec2 at_site = vec2(corrected_by_one(value.x, north_west.x), corrected_by_one(value.y, north_west.y));
  vec2 between = vec2(corrected_by_two(value.x, north_west.x, south_east.x),
                      corrected_by_two(value.y, north_west.y, south_east.y));
  vec2 amid = vec2(corrected_by_four(value.x, north_west.x, north_east.x, south_west.x, south_east.x),
                   corrected_by_four(value.y, north_west.y, north_east.y, south_west.y, south_east.y));
  float count = odd.x + odd.y;
  return count > 1.5 ? amid : count > 0.5 ? between : at_site;
}
