// The two numbers of the site whose pixel centre is p, from texels of two side by side: rg of columns 2i, ba of columns 2i + 1.
vec2 site_in(sampler2DRect texels, vec2 p) {
  vec4 pair = texture2DRect(texels, vec2(floor(0.5 * p.x) + 0.5, p.y));
  return fract(0.5 * p.x) < 0.5 ? pair.rg : pair.ba;
}
