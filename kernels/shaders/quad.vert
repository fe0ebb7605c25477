#version 120
// The quad that covers the image, one fragment per site.

attribute vec2 corner;

void main() { gl_Position = vec4(corner, 0.0, 1.0); }
