// Collects what site.inc's Site needs, for every shading language. The includer supplies
//
//   POSITION               vec2 with pixel centres at .5, or ivec2
//   displacement_at(p)     vec2: dx, dy
//   inverse_modulus_at(p)  1 / modulus
//   observation_at(p)      vec3: target x, target y, modulus (thesis Tab. 6.2)
//   confidence_at(p)       vec4: cx, cy, and where the rule needs them 1 / curvature of x and y
//   inputs_at(p)           vec4: the energy's own; only where HDM_INPUTS is above 0

#ifdef INTERIOR // nothing that is gathered for is at the border: no neighbour is outside
#define neighbour(centre, offset, size) ((centre) + (offset))
#else
// Which site stands for the neighbour at `offset`: itself, or the centre where it is outside (thesis 6.2.6).
POSITION neighbour(POSITION centre, POSITION offset, POSITION size) {
  POSITION site = centre + offset;
  bool inside = all(greaterThanEqual(site, POSITION(0))) && all(lessThan(site, size));
  return inside ? site : centre;
}
#endif

Site gather(POSITION at, POSITION size, real penalty) {
  POSITION north_west = neighbour(at, POSITION(-1, -1), size);
  POSITION north = neighbour(at, POSITION(0, -1), size);
  POSITION north_east = neighbour(at, POSITION(1, -1), size);
  POSITION west = neighbour(at, POSITION(-1, 0), size);
  POSITION east = neighbour(at, POSITION(1, 0), size);
  POSITION south_west = neighbour(at, POSITION(-1, 1), size);
  POSITION south = neighbour(at, POSITION(0, 1), size);
  POSITION south_east = neighbour(at, POSITION(1, 1), size);

  vec2 d_north_west = displacement_at(north_west);
  vec2 d_north = displacement_at(north);
  vec2 d_north_east = displacement_at(north_east);
  vec2 d_west = displacement_at(west);
  vec2 d_centre = displacement_at(at);
  vec2 d_east = displacement_at(east);
  vec2 d_south_west = displacement_at(south_west);
  vec2 d_south = displacement_at(south);
  vec2 d_south_east = displacement_at(south_east);
  vec3 observation = observation_at(at);
  vec4 confidence = confidence_at(at);

  Site site;
  site.dx = Neighbours(d_north_west.x, d_north.x, d_north_east.x, d_west.x, d_centre.x, d_east.x,
                       d_south_west.x, d_south.x, d_south_east.x);
  site.dy = Neighbours(d_north_west.y, d_north.y, d_north_east.y, d_west.y, d_centre.y, d_east.y,
                       d_south_west.y, d_south.y, d_south_east.y);
  site.inverse_modulus =
      Neighbours(inverse_modulus_at(north_west), inverse_modulus_at(north), inverse_modulus_at(north_east),
                 inverse_modulus_at(west), inverse_modulus_at(at), inverse_modulus_at(east),
                 inverse_modulus_at(south_west), inverse_modulus_at(south), inverse_modulus_at(south_east));
  site.modulus = observation.z;
  site.target_x = observation.x;
  site.target_y = observation.y;
  site.confidence_x = confidence.x;
  site.confidence_y = confidence.y;
  site.penalty = penalty;
  site.inverse_curvature_x = confidence.z;
  site.inverse_curvature_y = confidence.w;
#if HDM_INPUTS > 0
  vec4 i_north_west = inputs_at(north_west);
  vec4 i_north = inputs_at(north);
  vec4 i_north_east = inputs_at(north_east);
  vec4 i_west = inputs_at(west);
  vec4 i_centre = inputs_at(at);
  vec4 i_east = inputs_at(east);
  vec4 i_south_west = inputs_at(south_west);
  vec4 i_south = inputs_at(south);
  vec4 i_south_east = inputs_at(south_east);
#endif
#if HDM_INPUTS > 0
  site.first_input = Neighbours(i_north_west.x, i_north.x, i_north_east.x, i_west.x, i_centre.x,
                                i_east.x, i_south_west.x, i_south.x, i_south_east.x);
#endif
#if HDM_INPUTS > 1
  site.second_input = Neighbours(i_north_west.y, i_north.y, i_north_east.y, i_west.y, i_centre.y,
                                 i_east.y, i_south_west.y, i_south.y, i_south_east.y);
#endif
#if HDM_INPUTS > 2
  site.third_input = Neighbours(i_north_west.z, i_north.z, i_north_east.z, i_west.z, i_centre.z,
                                i_east.z, i_south_west.z, i_south.z, i_south_east.z);
#endif
#if HDM_INPUTS > 3
  site.fourth_input = Neighbours(i_north_west.w, i_north.w, i_north_east.w, i_west.w, i_centre.w,
                                 i_east.w, i_south_west.w, i_south.w, i_south_east.w);
#endif
  return site;
}
