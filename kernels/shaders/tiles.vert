#version 120
#extension GL_ARB_texture_rectangle : require
// A point per tile of the image, as large as the tile (glPointSize), or several on a side of it. The viewport covers
// whole tiles: what is beyond the image is cut off.

attribute vec2 corner; // column and row of the point
uniform vec2 grid;     // tiles in a row, in a column
const float points = float(POINTS); // on a side of a tile
#ifdef ACTIVE
uniform sampler2DRect awake; // a texel per tile: 0 where nothing can change
#endif

void main() {
  gl_Position = vec4((2.0 * corner + vec2(1.0)) / (points * grid) - vec2(1.0), 0.0, 1.0);
#ifdef ACTIVE
  if (texture2DRect(awake, floor(corner / points) + vec2(0.5)).r == 0.0) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0); // outside: nothing is drawn
  }
#endif
}
