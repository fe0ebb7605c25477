#version 450
#extension GL_GOOGLE_include_directive : require

// One sweep over the tiles of a list, a work group per tile.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define HDM_CONSTANT const
#define integer uint

layout(local_size_x_id = 8) in; // TILE_WIDTH / COLUMNS
layout(constant_id = 0) const int rule = 0;
layout(constant_id = 1) const int colours = 1;
layout(constant_id = 2) const int step_count = 1;
layout(constant_id = 3) const uint tile_class = 0u;
layout(constant_id = 4) const bool wakes = false; // what may change in the next sweep is put on the next list
layout(constant_id = 5) const int TILE_WIDTH = 32;
layout(constant_id = 6) const int TILE_HEIGHT = 16;
layout(constant_id = 7) const int COLUMNS = 1;
const int WINDOW = 6; // of the widest: an array's length is no constant that is given later

#include "level.vulkan.glsl"
#include "tile_class.inc"
#include "wake.glsl"

const bool border = (tile_class & border_bit) != 0u;
const bool observed = (tile_class & observed_bit) != 0u;
const bool elastic = (tile_class & elastic_bit) != 0u;

#include "site.inc"
#include "energy.inc"
#include "update.inc"

vec2 displacement_at(int i) { return texelFetch(displacement, i).xy; }
vec2 material_at(int i) { return texelFetch(material, i).xy; }
vec4 observation_at(int i) { return texelFetch(observation, i); }
vec2 inverse_curvature_at(int i) { return texelFetch(inverse_curvature, i).xy; }
#if HDM_INPUTS > 0
vec4 inputs_at(int i) { return texelFetch(inputs, first_input + i); }
#endif
void store(int i, Displacement next) { imageStore(improved, i, vec4(next.x, next.y, 0.0, 0.0)); }

#include "tile.glsl"

void main() {
  ivec2 tile = listed_tile(gl_WorkGroupID, tile_class);
  if (tile.x >= 0) {
    int seen_from = sweep_tile(tile, int(gl_LocalInvocationID.x), ivec2(width, height), penalty,
                               Sweep(colour, strength, number, seed));
    if (wakes) {
      wake(tile, seen_from);
    }
  }
}
