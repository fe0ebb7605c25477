#version 120
#extension GL_ARB_texture_rectangle : require
// Whether anything can change in a tile, a texel per tile: whether the last sweep changed something in its CELLS x CELLS
// cells or in those around them. Beyond the image's border the nearest cell is fetched, which is one of them.

uniform sampler2DRect cells; // r: 1 where a site of the cell changed

void main() {
  vec2 first = floor(gl_FragCoord.xy) * float(CELLS) - vec2(0.5);
  float changed = 0.0;
  for (int y = 0; y < CELLS + 2; ++y) {
    for (int x = 0; x < CELLS + 2; ++x) {
      changed = max(changed, texture2DRect(cells, first + vec2(float(x), float(y))).r);
    }
  }
  gl_FragColor = vec4(changed);
}
