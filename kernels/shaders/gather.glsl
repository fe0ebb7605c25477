// Collects what site.inc's Site needs, for fragment shaders. The includer supplies
//
//   POSITION                 vec2 with pixel centres at .5, or ivec2; of a volume vec3, whose z is the slice
//   displacement_at(p)       Vector
//   inverse_modulus_at(p)    1 / modulus
//   observation_at(p)        WithModulus: the target, the modulus (thesis Tab. 6.2)
//   confidence_at(p)         vec4: cx, cy, and where the rule needs them 1 / curvature of x and y; of a volume cx, cy, cz
//   inverse_curvature_at(p)  Vector; of a volume only
//   inputs_at(p)             vec4: the energy's own; only where HDM_INPUTS is above 0

#include "seen.glsl"

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

SeenSite seen_site(POSITION p) {
  SeenSite seen;
  seen.displacement = displacement_at(p);
  seen.material = vec2(inverse_modulus_at(p));
#if HDM_INPUTS > 0
  seen.inputs = inputs_at(p);
#endif
  return seen;
}

// What is seen `x` columns and `y` rows from a site.
Seen seen_at(POSITION at, int x, int y, POSITION size) {
  Seen seen;
  seen.here = seen_site(neighbour(at, POSITION(x, y AND_Z(0)), size));
#if HDM_AXES > 2
  seen.near = seen_site(neighbour(at, POSITION(x, y, -1), size));
  seen.far = seen_site(neighbour(at, POSITION(x, y, 1), size));
#endif
  return seen;
}

Site gather(POSITION at, POSITION size, real penalty) {
  WithModulus observation = observation_at(at);
  vec4 confidence = confidence_at(at);
#if HDM_AXES > 2
  Vector inverse_curvature = inverse_curvature_at(at);
#else
  Vector inverse_curvature = confidence.zw;
#endif
  return site_of(seen_at(at, -1, -1, size), seen_at(at, 0, -1, size), seen_at(at, 1, -1, size), seen_at(at, -1, 0, size),
                 seen_at(at, 0, 0, size), seen_at(at, 1, 0, size), seen_at(at, -1, 1, size), seen_at(at, 0, 1, size),
                 seen_at(at, 1, 1, size), observation.MODULUS, observation.COMPONENTS, confidence.COMPONENTS,
                 inverse_curvature, penalty);
}
