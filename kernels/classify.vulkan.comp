#version 450
#extension GL_GOOGLE_include_directive : require

// Puts every tile of a level on the list of its class, an invocation per tile.

layout(local_size_x = 64) in;
layout(constant_id = 0) const int interior_classes = 3; // 0: all tiles are general; 1: those at the border; 3: few more

#include "tile_size.vulkan.h"
#include "level.vulkan.glsl"

// Of a tile whose rim is inside the image, numbered as in backends/tiles.hpp.
int interior_class(ivec2 first) {
  ivec2 end = first + tile_size;
  bool observed = false;
  for (int y = first.y; y < end.y; ++y) {
    for (int x = first.x; x < end.x; ++x) {
      observed = observed || texelFetch(observation, index_of(ivec2(x, y))).zw != vec2(0.0);
    }
  }
  precise vec2 moduli = texelFetch(material, index_of(first)).xy;
  bool elastic = moduli.x * moduli.y != 1.0;
  for (int y = first.y - 1; y <= end.y; ++y) {
    for (int x = first.x - 1; x <= end.x; ++x) {
      elastic = elastic || texelFetch(material, index_of(ivec2(x, y))).xy != moduli;
    }
  }
  return observed ? 3 : elastic ? 1 : 0;
}

void main() {
  int tile = int(gl_WorkGroupID.y * most_groups_across + gl_WorkGroupID.x) * 64 + int(gl_LocalInvocationID.x);
  if (tile < tile_count) {
    ivec2 first = ivec2(tile % tiles_across, tile / tiles_across) * tile_size;
    bool interior = all(greaterThan(first, ivec2(0))) && all(lessThan(first + tile_size, ivec2(width, height)));
    int tile_class = class_count - 1;
    if (interior_classes > 0 && interior) {
      tile_class = interior_classes > 1 ? interior_class(first) : 3;
    }
    tiles[tile] = uint(tile_class);
    append_tile(uint(tile), tile_class, list, length);
  }
}
