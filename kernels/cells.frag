#version 120
#extension GL_ARB_texture_rectangle : require
// Whether the last sweep changed any site of a cell of CELL x CELL sites, a texel per cell. Drawn for the tiles that were
// awake; in those that were not, nothing changed the last time either.

uniform sampler2DRect image; // a: 1 where the sweep changed the site

void main() {
  vec2 first = floor(gl_FragCoord.xy) * float(CELL) + vec2(0.5);
  float changed = 0.0;
  for (int y = 0; y < CELL; ++y) {
    for (int x = 0; x < CELL; ++x) {
      changed = max(changed, texture2DRect(image, first + vec2(float(x), float(y))).a);
    }
  }
  gl_FragColor = vec4(changed);
}
