#version 120
#extension GL_ARB_texture_rectangle : require
// probe.inc, a fragment for each case.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE

uniform sampler2DRect source; // two texels side by side: a, b, c, d; e, operation

#include "probe.inc"

void main() {
  vec2 at = vec2(2.0 * floor(gl_FragCoord.x) + 0.5, gl_FragCoord.y);
  vec4 first = texture2DRect(source, at);
  vec4 second = texture2DRect(source, at + vec2(1.0, 0.0));
  gl_FragColor = vec4(probed(second.y, first.x, first.y, first.z, first.w, second.x), 0.0, 0.0, 0.0);
}
