#version 430
#extension GL_GOOGLE_include_directive : require

// One sweep over the tiles of one class, or over those of them that can see a change. Work groups take tiles in turn.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define HDM_CONSTANT const

#ifdef VULKAN
layout(constant_id = 0) const int rule = 0;
layout(constant_id = 1) const int colours = 1;
layout(constant_id = 2) const int step_count = 1;
layout(constant_id = 3) const uint tile_class = 0u;
layout(constant_id = 4) const bool leaves_out = false; // whether only tiles are visited that can see a change
layout(constant_id = 5) const int TILE_WIDTH = 32;
layout(constant_id = 6) const int TILE_HEIGHT = 16;
layout(constant_id = 7) const int COLUMNS = 1;
layout(local_size_x_id = 8) in; // TILE_WIDTH / COLUMNS
const int WINDOW = 4; // of the widest: an array's length is no constant that is given later
#else // supplied after #version
const int rule = RULE;
const int colours = COLOURS;
const int step_count = STEP_COUNT;
const uint tile_class = CLASS;
const bool leaves_out = ACTIVE != 0;
layout(local_size_x = LANES) in;
const int WINDOW = COLUMNS + 2;
#endif

#include "fields.glsl"

layout(binding = 10) uniform samplerBuffer inverse_curvature; // where the rule needs it
layout(binding = 4, std430) readonly buffer Tiles { uint tiles[]; }; // their numbers, class after class
layout(binding = 5, std430) buffer Flags { uint flags[]; }; // twice per tile the last sweep to visit it, odd and even
PARAMETERS_AND_STEPS(16)

const bool border = (tile_class & 4u) != 0u; // the bits of backends/shared/tiles.hpp
const bool observed = (tile_class & 2u) != 0u;
const bool elastic = (tile_class & 1u) != 0u;

#include "site.inc"
#include "energy.inc"
#include "update.inc"

// Parameters of backends/session/sweeps.cpp: penalty; colour, strength, number and seed of update.inc's Sweep; width,
// height and depth; then
#define tiles_across parameters[8]
#define tiles_down parameters[9] // of a slice
#define tile_count parameters[10]
#define every parameters[11] // whether every tile is visited
#define stamp uint(parameters[12]) // of this sweep, another one for each since the flags were cleared
#define first_input_texel parameters[13] // texel of the level's first site
#define first_listed uint(parameters[14]) // of the class
#define end_listed uint(parameters[15])

Vector displacement_at(int i) { return texelFetch(displacement, i).COMPONENTS; }
vec2 material_at(int i) { return texelFetch(material, i).xy; }
Vector target_at(int i) { return target_of(i); }
Vector confidence_at(int i) { return confidence_of(i); }
Vector inverse_curvature_at(int i) { return texelFetch(inverse_curvature, i).COMPONENTS; }
#if HDM_INPUTS > 0
vec4 inputs_at(int i) { return texelFetch(inputs, first_input_texel + i); }
#endif
void store(int i, Displacement next) { imageStore(improved, i, vec4(next.x, next.y AND_Z(next.z), REST)); }

#include "tile.glsl"

// Has the tiles visited in the next sweep that sweep_tile() named. Several invocations may store the same.
void wake(ivec2 tile, int seen_from) {
  uint next = (1u - (stamp & 1u)) * uint(tile_count);
  for (int bit = 0; bit < 9; ++bit) {
    ivec2 other = tile + ivec2(bit % 3 - 1, bit / 3 - 1);
    if ((seen_from >> bit & 1) != 0 && other.x >= 0 && other.x < tiles_across && other.y >= 0 && other.y < tiles_down) {
      flags[next + uint(other.y * tiles_across + other.x)] = stamp + 1u;
    }
  }
}

// The first place in the list, of every `step`-th from `place` on, whose tile can see a change; else the end.
uint next_visited(uint place, uint step) {
  while (place < end_listed && leaves_out && every == 0 &&
         flags[(stamp & 1u) * uint(tile_count) + tiles[place]] != stamp) {
    place += step;
  }
  return place;
}

void main() {
  ivec3 size = ivec3(parameters[5], parameters[6], parameters[7]);
  Sweep sweep = Sweep(intBitsToFloat(parameters[1]), intBitsToFloat(parameters[2]), intBitsToFloat(parameters[3]),
                      intBitsToFloat(parameters[4]));
  uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
  uint place = next_visited(first_listed + group, groups);
  if (place >= end_listed) {
    return;
  }
  // The condition stands last: rasterizers on the CPU execute what a branch leaves out, but for loops that have ended.
  do {
    int number = int(tiles[place]);
    ivec3 tile = ivec3(number % tiles_across, number / tiles_across % tiles_down, number / (tiles_across * tiles_down));
    int seen_from = sweep_tile(tile, int(gl_LocalInvocationID.x), size, intBitsToFloat(parameters[0]), sweep);
    if (leaves_out) {
      wake(tile.xy, seen_from);
    }
    place = next_visited(place + groups, groups);
  } while (place < end_listed);
}
