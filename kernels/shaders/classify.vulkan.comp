#version 450
#extension GL_GOOGLE_include_directive : require

// Puts every tile of a level on the list of its class, an invocation per tile.

#define real float
#define integer uint
#define HDM_CONSTANT const
#define HDM_FUNCTION
#define HDM_PRECISE precise

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint classes = 128u; // in use, for class_in_use()

layout(constant_id = 1) const int TILE_WIDTH = 32;
layout(constant_id = 2) const int TILE_HEIGHT = 16;

#include "level.vulkan.glsl"
#include "tile_class.inc"
#include "wake.glsl"

bool any_other_confidence(int y, int first, int end, float confidence_x, float confidence_y) {
  bool other = false;
  for (int x = first; x < end; ++x) {
    other = other || texelFetch(observation, index_of(ivec2(x, y))).zw != vec2(confidence_x, confidence_y);
  }
  return other;
}

bool any_other_modulus(int y, int first, int end, float modulus) {
  bool other = false;
  for (int x = first; x < end; ++x) {
    other = other || texelFetch(material, index_of(ivec2(x, y))).x != modulus;
  }
  return other;
}

bool any_other_inverse(int y, int first, int end, float inverse) {
  bool other = false;
  for (int x = first; x < end; ++x) {
    other = other || texelFetch(material, index_of(ivec2(x, y))).y != inverse;
  }
  return other;
}

#include "classify.inc"

void main() {
  int tile = int(gl_WorkGroupID.y * most_groups_across + gl_WorkGroupID.x) * 64 + int(gl_LocalInvocationID.x);
  if (tile < tile_count) {
    ivec2 first = ivec2(tile % tiles_across, tile / tiles_across) * ivec2(TILE_WIDTH, TILE_HEIGHT);
    vec2 moduli = texelFetch(material, index_of(first)).xy;
    uint tile_class =
        class_of_tile(classes, first.x, first.y, TILE_WIDTH, TILE_HEIGHT, width, height, moduli.x, moduli.y);
    tiles[classes_section * uint(tile_count) + uint(tile)] = tile_class;
    append_tile(uint(tile), tile_class, list, length);
  }
}
