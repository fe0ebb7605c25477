#version 450
#extension GL_GOOGLE_include_directive : require

// Puts every tile of a level on the list of its class, an invocation per tile.

layout(local_size_x = 64) in;
layout(constant_id = 0) const int classes = 4; // the first 1, 2 or all 4: how far tiles are told apart

#include "tile_size.vulkan.h"
#include "level.vulkan.glsl"

// Of a tile whose rim is inside the image.
int interior_class(ivec2 first) {
  ivec2 end = first + tile_size;
  vec2 moduli = texelFetch(observation, index_of(first)).zw;
  bool uniform_modulus = true;
  bool observed = false;
  for (int y = first.y - 1; y <= end.y; ++y) {
    for (int x = first.x - 1; x <= end.x; ++x) {
      uniform_modulus = uniform_modulus && texelFetch(observation, index_of(ivec2(x, y))).zw == moduli;
    }
  }
  for (int y = first.y; y < end.y; ++y) {
    for (int x = first.x; x < end.x; ++x) {
      observed = observed || confidence_at(ivec2(x, y)).xy != vec2(0.0);
    }
  }
  return observed ? class_interior : uniform_modulus ? class_uniform : class_unobserved;
}

void main() {
  int tile = int(gl_WorkGroupID.y * most_groups_across + gl_WorkGroupID.x) * 64 + int(gl_LocalInvocationID.x);
  if (tile < tile_count) {
    ivec2 first = ivec2(tile % tiles_across, tile / tiles_across) * tile_size;
    bool interior = all(greaterThan(first, ivec2(0))) && all(lessThan(first + tile_size, ivec2(width, height)));
    int tile_class = class_border;
    if (classes > 1 && interior) {
      tile_class = classes > 2 ? interior_class(first) : class_interior;
    }
    tiles[tile] = uint(tile_class);
    append_tile(uint(tile), tile_class, list, length);
  }
}
