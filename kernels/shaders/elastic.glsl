// What kernels of the elastic energy do with what they have fetched, for every shading language. Compiled after cell.inc
// and site.inc; the includer supplies
//
//   matrix_at(number, i)     vec4: texel i of the matrix of a masked cell (elastic_matrices())

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

// `moments` and `more` as ElasticTexels has them, displacements of the corners in reading order. `may_be_masked` is a
// constant.
CellForces forces_of_cell(bool may_be_masked, vec4 moments, vec4 more, vec2 top_left, vec2 top_right, vec2 bottom_left,
                          vec2 bottom_right, PoissonRatio ratio) {
  CellTension tension =
      cell_tension(CellMoments(moments.x, moments.y, moments.z, moments.w, more.x, more.y),
                   CellCorners(top_left.x, top_right.x, bottom_left.x, bottom_right.x),
                   CellCorners(top_left.y, top_right.y, bottom_left.y, bottom_right.y), ratio);
  CellForces forces = CellForces(force_on_top_left(tension), force_on_top_right(tension),
                                 force_on_bottom_left(tension), force_on_bottom_right(tension));
  if (may_be_masked) {
    // A loop, not a branch: rasterizers on the CPU execute both sides of a branch, but leave a loop when all are done.
    int corner = more.z > 0.0 ? 0 : 4;
    if (corner == 0) {
      forces = CellForces(Force(0.0, 0.0), Force(0.0, 0.0), Force(0.0, 0.0), Force(0.0, 0.0));
    }
    for (; corner < 4; ++corner) {
      vec2 moved = corner < 2 ? (corner == 0 ? top_left : top_right) : (corner == 2 ? bottom_left : bottom_right);
      HDM_PRECISE float number = more.z - 1.0;
      forces.top_left = more_masked_force(forces.top_left, matrix_at(number, corner), moved);
      forces.top_right = more_masked_force(forces.top_right, matrix_at(number, 4 + corner), moved);
      forces.bottom_left = more_masked_force(forces.bottom_left, matrix_at(number, 8 + corner), moved);
      forces.bottom_right = more_masked_force(forces.bottom_right, matrix_at(number, 12 + corner), moved);
    }
  }
  return forces;
}

// `response`: xx, xy, yy.
vec2 relaxed_site(vec2 displacement, vec4 response, Force residual) {
  return vec2(relaxed(displacement.x, response.x, residual.x, response.y, residual.y),
              relaxed(displacement.y, response.z, residual.y, response.y, residual.x));
}

vec2 free_parts(vec2 residual, vec4 response) {
  return vec2(free_part(residual.x, response.x), free_part(residual.y, response.z));
}

// Component by component.
vec2 restricted_sites(vec2 before, vec2 at, vec2 after) {
  return vec2(restricted(before.x, at.x, after.x), restricted(before.y, at.y, after.y));
}

// By the coarse sites around, two or four of which may be one.
vec2 corrected_site(vec2 value, bool odd_x, bool odd_y, vec2 north_west, vec2 north_east, vec2 south_west,
                    vec2 south_east) {
  vec2 at_site = vec2(corrected_by_one(value.x, north_west.x), corrected_by_one(value.y, north_west.y));
  vec2 between = vec2(corrected_by_two(value.x, north_west.x, south_east.x),
                      corrected_by_two(value.y, north_west.y, south_east.y));
  vec2 amid = vec2(corrected_by_four(value.x, north_west.x, north_east.x, south_west.x, south_east.x),
                   corrected_by_four(value.y, north_west.y, north_east.y, south_west.y, south_east.y));
  return odd_x && odd_y ? amid : odd_x || odd_y ? between : at_site;
}
