#version 120
#extension GL_ARB_texture_rectangle : require
// Lets a fragment pass where the last iteration changed the displacement: an occlusion query counts them.

uniform sampler2DRect image;
uniform sampler2DRect previous;

void main() {
  vec2 now = texture2DRect(image, gl_FragCoord.xy).rg;
  vec2 before = texture2DRect(previous, gl_FragCoord.xy).rg;
  if (now == before) {
    discard;
  }
  gl_FragColor = vec4(1.0);
}
