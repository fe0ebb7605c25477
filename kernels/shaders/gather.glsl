// Collects what site.inc's Site needs, for fragment shaders. The includer supplies
//
//   POSITION               vec2 with pixel centres at .5, or ivec2
//   displacement_at(p)     vec2: dx, dy
//   inverse_modulus_at(p)  1 / modulus
//   observation_at(p)      vec3: target x, target y, modulus (thesis Tab. 6.2)
//   confidence_at(p)       vec4: cx, cy, and where the rule needs them 1 / curvature of x and y
//   inputs_at(p)           vec4: the energy's own; only where HDM_INPUTS is above 0

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

Seen seen_at(POSITION p) {
  Seen seen;
  seen.here.displacement = displacement_at(p);
  seen.here.material = vec2(inverse_modulus_at(p));
#if HDM_INPUTS > 0
  seen.here.inputs = inputs_at(p);
#endif
  return seen;
}

Site gather(POSITION at, POSITION size, real penalty) {
  vec3 observation = observation_at(at);
  vec4 confidence = confidence_at(at);
  return site_of(seen_at(neighbour(at, POSITION(-1, -1), size)), seen_at(neighbour(at, POSITION(0, -1), size)),
                 seen_at(neighbour(at, POSITION(1, -1), size)), seen_at(neighbour(at, POSITION(-1, 0), size)),
                 seen_at(at), seen_at(neighbour(at, POSITION(1, 0), size)),
                 seen_at(neighbour(at, POSITION(-1, 1), size)), seen_at(neighbour(at, POSITION(0, 1), size)),
                 seen_at(neighbour(at, POSITION(1, 1), size)), observation.z, observation.xy, confidence.xy,
                 confidence.zw, penalty);
}
