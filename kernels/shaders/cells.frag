#version 120
#extension GL_ARB_texture_rectangle : require
// Whether the last sweep changed any site of a cell of CELL x CELL texels, a texel per cell. Drawn for the tiles that were
// awake; in those that were not, nothing changed the last time either.

uniform sampler2DRect image;
uniform sampler2DRect previous;

void main() {
  vec2 first = floor(gl_FragCoord.xy) * float(CELL) + vec2(0.5);
  bool changed = false;
  for (int y = 0; y < CELL; ++y) {
    for (int x = 0; x < CELL; ++x) {
      vec2 texel = first + vec2(float(x), float(y));
      changed = changed || texture2DRect(image, texel) != texture2DRect(previous, texel);
    }
  }
  gl_FragColor = vec4(float(changed));
}
