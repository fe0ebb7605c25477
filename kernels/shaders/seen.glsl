// What a site needs of itself and of the sites around it, for every shading language.

#include "axes.glsl"

struct SeenSite {
  Vector displacement;
  vec2 material; // modulus, 1 / modulus
#if HDM_INPUTS > 0
  vec4 inputs; // the energy's own
#endif
};

// What is seen at a column and a row: a site, and in a volume those before and behind it, too.
struct Seen {
  SeenSite here;
#if HDM_AXES > 2
  SeenSite near;
  SeenSite far;
#endif
};

#define NINE(at, of) nw.at.of, n.at.of, ne.at.of, w.at.of, c.at.of, e.at.of, sw.at.of, s.at.of, se.at.of
#if HDM_AXES > 2
#define AROUND(of) Neighbours(NINE(here, of), Plane(NINE(near, of)), Plane(NINE(far, of)))
#else
#define AROUND(of) Neighbours(NINE(here, of))
#endif

Site site_of(Seen nw, Seen n, Seen ne, Seen w, Seen c, Seen e, Seen sw, Seen s, Seen se, real modulus, Vector target,
             Vector confidence, Vector inverse_curvature, real penalty) {
  Site site;
  site.dx = AROUND(displacement.x);
  site.dy = AROUND(displacement.y);
  site.inverse_modulus = AROUND(material.y);
  site.modulus = modulus;
  site.target_x = target.x;
  site.target_y = target.y;
  site.confidence_x = confidence.x;
  site.confidence_y = confidence.y;
  site.penalty = penalty;
  site.inverse_curvature_x = inverse_curvature.x;
  site.inverse_curvature_y = inverse_curvature.y;
#if HDM_AXES > 2
  site.dz = AROUND(displacement.z);
  site.target_z = target.z;
  site.confidence_z = confidence.z;
  site.inverse_curvature_z = inverse_curvature.z;
#endif
#if HDM_INPUTS > 0
  site.first_input = AROUND(inputs.x);
#endif
#if HDM_INPUTS > 1
  site.second_input = AROUND(inputs.y);
#endif
#if HDM_INPUTS > 2
  site.third_input = AROUND(inputs.z);
#endif
#if HDM_INPUTS > 3
  site.fourth_input = AROUND(inputs.w);
#endif
  return site;
}
