#version 120
#extension GL_ARB_texture_rectangle : require
// The sites of the full image that a level samples.

uniform sampler2DRect full;
uniform sampler2DRect table; // a: the sampled pixel's centre, of the columns in row 0, of the rows in row 1

void main() {
  float x = texture2DRect(table, vec2(gl_FragCoord.x, 0.5)).a;
  float y = texture2DRect(table, vec2(gl_FragCoord.y, 1.5)).a;
  gl_FragColor = texture2DRect(full, vec2(x, y));
}
