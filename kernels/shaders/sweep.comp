#version 430
// One sweep over a list of tiles of one class as an OpenGL 4.3 compute shader, a group per tile. Buffer textures: on
// rasterizers that run on the CPU their fetches are several times faster than storage buffers and twice as fast as
// two-dimensional textures.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define HDM_CONSTANT const
#define integer uint

// RULE, COLOURS, STEP_COUNT, TILE_WIDTH, TILE_HEIGHT, COLUMNS, LANES, CLASS and ACTIVE are supplied after #version; STEPS
// too, where the candidates are to be constants: a tenth faster.
layout(local_size_x = LANES) in; // TILE_WIDTH / COLUMNS

layout(binding = 0) uniform samplerBuffer image;       // rg: displacement
layout(binding = 1) uniform samplerBuffer material;    // rg: modulus, 1 / modulus
layout(binding = 2) uniform samplerBuffer observation; // rg: target, ba: confidence
layout(binding = 3) uniform samplerBuffer curvature;   // rg: 1 / curvature, where the rule needs it
#if HDM_INPUTS > 0
layout(binding = 11) uniform samplerBuffer inputs; // the energy's own, of all levels one after the other
layout(location = 26) uniform int first_input;    // texel of the level's first site
#endif
layout(binding = 0, rg32f) uniform restrict writeonly imageBuffer next_image;
layout(binding = 0, std430) restrict buffer Tiles { uint tiles[]; }; // this and the next as wake.glsl has them
layout(binding = 1, std430) restrict buffer Lengths { uvec4 lengths[]; };
layout(location = 0) uniform ivec2 dimension;
layout(location = 1) uniform float penalty;
layout(location = 18) uniform vec4 turn; // colour, strength, number, seed of update.inc's Sweep
layout(location = 19) uniform int tiles_across; // this and the next as wake.glsl has them
layout(location = 20) uniform int tile_count;
layout(location = 21) uniform int list;
layout(location = 22) uniform int length;
layout(location = 23) uniform int next_list;
layout(location = 24) uniform int next_length;
layout(location = 25) uniform int stamp;
const int WINDOW = COLUMNS + 2;
const int rule = RULE;
const int colours = COLOURS;
const int step_count = STEP_COUNT;
#ifdef STEPS
const float steps[16] = float[16](STEPS);
#else
layout(location = 2) uniform float steps[16];
#endif

#include "tile_class.inc"
#include "wake.glsl"

const uint tile_class = CLASS;
const bool border = (tile_class & border_bit) != 0u;
const bool observed = (tile_class & observed_bit) != 0u;
const bool elastic = (tile_class & elastic_bit) != 0u;

#include "site.inc"
#include "energy.inc"
#include "update.inc"

vec2 displacement_at(int i) { return texelFetch(image, i).rg; }
vec2 material_at(int i) { return texelFetch(material, i).rg; }
vec4 observation_at(int i) { return texelFetch(observation, i); }
vec2 inverse_curvature_at(int i) { return texelFetch(curvature, i).rg; }
#if HDM_INPUTS > 0
vec4 inputs_at(int i) { return texelFetch(inputs, first_input + i); }
#endif
void store(int i, Displacement next) { imageStore(next_image, i, vec4(next.x, next.y, 0.0, 0.0)); }

#include "tile.glsl"

void main() {
  ivec2 tile = listed_tile(gl_WorkGroupID, tile_class);
  if (tile.x >= 0) {
    int seen_from = sweep_tile(tile, int(gl_LocalInvocationID.x), dimension, penalty,
                               Sweep(turn.x, turn.y, turn.z, turn.w));
    if (ACTIVE) {
      wake(tile, seen_from);
    }
  }
}
