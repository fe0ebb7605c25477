// What a site needs of itself and of the eight sites around it, for every shading language.

struct Seen {
  vec2 displacement;
  vec2 material; // modulus, 1 / modulus
#if HDM_INPUTS > 0
  vec4 inputs; // the energy's own
#endif
};

#define AROUND(of) Neighbours(nw.of, n.of, ne.of, w.of, c.of, e.of, sw.of, s.of, se.of)

Site site_of(Seen nw, Seen n, Seen ne, Seen w, Seen c, Seen e, Seen sw, Seen s, Seen se, real modulus, vec2 target,
             vec2 confidence, vec2 inverse_curvature, real penalty) {
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
