#version 120
#extension GL_ARB_texture_rectangle : require
// Lets a fragment pass where the last iteration changed the displacement, a fragment per site:
// an occlusion query counts them.

uniform sampler2DRect image;
uniform sampler2DRect previous;

#include "two_sites.glsl"

void main() {
  vec2 now = site_in(image, gl_FragCoord.xy);
  vec2 before = site_in(previous, gl_FragCoord.xy);
  if (now == before) {
    discard;
  }
  gl_FragColor = vec4(1.0);
}
