#version 430
#extension GL_GOOGLE_include_directive : require

// One sweep over a list of tiles of one class, a work group per tile.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define HDM_CONSTANT const
#define integer uint

#ifdef VULKAN
layout(constant_id = 0) const int rule = 0;
layout(constant_id = 1) const int colours = 1;
layout(constant_id = 2) const int step_count = 1;
layout(constant_id = 3) const uint tile_class = 0u;
layout(constant_id = 4) const bool wakes = false; // what may change in the next sweep is put on the next list
layout(constant_id = 5) const int TILE_WIDTH = 32;
layout(constant_id = 6) const int TILE_HEIGHT = 16;
layout(constant_id = 7) const int COLUMNS = 1;
layout(local_size_x_id = 8) in; // TILE_WIDTH / COLUMNS
const int WINDOW = 6; // of the widest: an array's length is no constant that is given later
#else // supplied after #version
const int rule = RULE;
const int colours = COLOURS;
const int step_count = STEP_COUNT;
const uint tile_class = CLASS;
const bool wakes = WAKES != 0;
layout(local_size_x = LANES) in;
const int WINDOW = COLUMNS + 2;
#endif

#include "fields.glsl"

layout(binding = 10) uniform samplerBuffer inverse_curvature; // where the rule needs it
layout(binding = 4, std430) buffer Tiles { uint tiles[]; };   // these three as wake.glsl has them
layout(binding = 5, std430) readonly buffer Lengths { uvec4 lengths[]; };
layout(binding = 6, std430) buffer AppendedLengths { uvec4 appended_lengths[]; };
PARAMETERS_AND_STEPS(14)

#include "tile_class.inc"

const bool border = (tile_class & border_bit) != 0u;
const bool observed = (tile_class & observed_bit) != 0u;
const bool elastic = (tile_class & elastic_bit) != 0u;

#include "site.inc"
#include "energy.inc"
#include "update.inc"

// ListedSweeps::Parameters of backends/session/sweeps.cpp: penalty, width, height, depth; colour, strength, number and seed
// of update.inc's Sweep; then
#define tiles_across parameters[8]
#define tile_count parameters[9]
#define list parameters[10]
#define next_list parameters[11]
#define stamp parameters[12]
#define first_input_texel parameters[13] // texel of the level's first site

#include "wake.glsl"

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

void main() {
  int place = listed_tile(gl_WorkGroupID, tile_class);
  if (place >= 0) {
    ivec3 size = ivec3(parameters[1], parameters[2], parameters[3]);
    int tiles_down = tile_count / (tiles_across * size.z);
    int row = place / tiles_across; // of tiles, of all slices
    ivec3 tile = ivec3(place % tiles_across, row % tiles_down, row / tiles_down);
    Sweep sweep = Sweep(intBitsToFloat(parameters[4]), intBitsToFloat(parameters[5]), intBitsToFloat(parameters[6]),
                        intBitsToFloat(parameters[7]));
    int seen_from = sweep_tile(tile, int(gl_LocalInvocationID.x), size, intBitsToFloat(parameters[0]), sweep);
    if (wakes) {
      wake(tile.xy, seen_from);
    }
  }
}
