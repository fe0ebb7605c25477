#version 300 es
// probe.inc in the language of WebGL 2: a pixel per case. GLSL ES 3.00 has no `precise`.

precision highp float;
precision highp int;
precision highp sampler2D;

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE

uniform sampler2D cases; // two texels a row: a, b, c, d; e, operation
out vec4 result;

#include "probe.inc"

void main() {
  vec4 first = texelFetch(cases, ivec2(0, int(gl_FragCoord.y)), 0);
  vec4 second = texelFetch(cases, ivec2(1, int(gl_FragCoord.y)), 0);
  result = vec4(probed(second.y, first.x, first.y, first.z, first.w, second.x), 0.0, 0.0, 0.0);
}
