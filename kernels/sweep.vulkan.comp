#version 450
#extension GL_GOOGLE_include_directive : require

// One sweep over the tiles of a list, a work group per tile.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise

#include "tile_size.vulkan.h"

// Measured on lavapipe: 1 fetches more and is a quarter slower; 4 is up to a sixth faster or slower, by size and scene.
const int COLUMNS = 2;

layout(local_size_x = TILE_WIDTH / COLUMNS) in;
layout(constant_id = 0) const int rule = 0;
layout(constant_id = 1) const int colours = 1;
layout(constant_id = 2) const int step_count = 1;
layout(constant_id = 3) const int tile_class = 0; // this and the next three are of backends/tiles.hpp
layout(constant_id = 4) const bool border = true;
layout(constant_id = 5) const bool observed = true;
layout(constant_id = 6) const bool elastic = true;
layout(constant_id = 7) const bool wakes = false; // what may change in the next sweep is put on the next list

#include "level.vulkan.glsl"

#include "energy.inc"
#include "update.inc"

vec2 displacement_at(int i) { return texelFetch(displacement, i).xy; }
vec2 material_at(int i) { return texelFetch(material, i).xy; }
vec4 observation_at(int i) { return texelFetch(observation, i); }
vec2 inverse_curvature_at(int i) { return texelFetch(inverse_curvature, i).xy; }
void store(int i, Displacement next) { imageStore(improved, i, vec4(next.x, next.y, 0.0, 0.0)); }

#include "tile.glsl"

// The tiles that see a change of this one are put on the next list, each once: atomicExchange decides by whom.
void wake(ivec2 tile, int seen_from) {
  ivec2 across = ivec2(tiles_across, tile_count / tiles_across);
  for (; seen_from != 0; seen_from &= seen_from - 1) {
    int bit = findLSB(seen_from);
    ivec2 to = tile + ivec2(bit % 3 - 1, bit / 3 - 1);
    if (all(greaterThanEqual(to, ivec2(0))) && all(lessThan(to, across))) {
      int woken = to.y * tiles_across + to.x;
      if (atomicExchange(tiles[tile_count + woken], uint(stamp)) != uint(stamp)) {
        append_tile(uint(woken), int(tiles[woken]), next_list, next_length);
      }
    }
  }
}

void main() {
  uint group = gl_WorkGroupID.y * most_groups_across + gl_WorkGroupID.x;
  if (group < lengths[length + tile_class].w) {
    int number_of_tile = int(tiles[list_begin(list, tile_class) + int(group)]);
    ivec2 tile = ivec2(number_of_tile % tiles_across, number_of_tile / tiles_across);
    int seen_from = sweep_tile(tile, int(gl_LocalInvocationID.x), ivec2(width, height), penalty,
                               Sweep(colour, strength, number, seed));
    if (wakes) {
      wake(tile, seen_from);
    }
  }
}
