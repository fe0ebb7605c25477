#version 430
// One sweep over a list of tiles of one class as an OpenGL 4.3 compute shader, a group per tile. Buffer textures: on
// rasterizers that run on the CPU their fetches are several times faster than storage buffers and twice as fast as
// two-dimensional textures.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise

// RULE, COLOURS, STEP_COUNT, TILE_WIDTH, TILE_HEIGHT, COLUMNS, LANES, CLASS, CLASSES, BORDER, OBSERVED, ELASTIC and
// ACTIVE are supplied after #version; STEPS too, where the candidates are to be constants: a tenth faster.
layout(local_size_x = LANES) in; // TILE_WIDTH / COLUMNS

layout(binding = 0) uniform samplerBuffer image;       // rg: displacement
layout(binding = 1) uniform samplerBuffer material;    // rg: modulus, 1 / modulus
layout(binding = 2) uniform samplerBuffer observation; // rg: target, ba: confidence
layout(binding = 3) uniform samplerBuffer curvature;   // rg: 1 / curvature, where the rule needs it
layout(binding = 0, rg32f) uniform restrict writeonly imageBuffer next_image;
layout(binding = 0, std430) restrict buffer Tiles { uint tiles[]; };
layout(binding = 1, std430) restrict buffer Arguments { uint arguments[]; };
layout(binding = 2, std430) restrict buffer Visited { uint visited[]; };
layout(binding = 3, std430) restrict readonly buffer Classes { uint classes[]; };
layout(location = 0) uniform ivec2 dimension;
layout(location = 1) uniform float penalty;
layout(location = 18) uniform vec4 turn; // colour, strength, number, seed of update.inc's Sweep
layout(location = 19) uniform uvec3 lists; // which of the three is read, which is written and its number, never 0
layout(location = 20) uniform uint first[CLASSES]; // where the lists of a class begin
const int rule = RULE;
const int colours = COLOURS;
const int step_count = STEP_COUNT;
#ifdef STEPS
const float steps[16] = float[16](STEPS);
#else
layout(location = 2) uniform float steps[16];
#endif
const bool border = BORDER;
const bool observed = OBSERVED;
const bool elastic = ELASTIC;

#include "energy.inc"
#include "update.inc"

vec2 displacement_at(int i) { return texelFetch(image, i).rg; }
vec2 material_at(int i) { return texelFetch(material, i).rg; }
vec4 observation_at(int i) { return texelFetch(observation, i); }
vec2 inverse_curvature_at(int i) { return texelFetch(curvature, i).rg; }
void store(int i, Displacement next) { imageStore(next_image, i, vec4(next.x, next.y, 0.0, 0.0)); }

#include "tile.glsl"
#include "wake.glsl"

void main() {
  ivec2 tile_dimension = (dimension + ivec2(TILE_WIDTH - 1, TILE_HEIGHT - 1)) / ivec2(TILE_WIDTH, TILE_HEIGHT);
  uint count = arguments[(lists.x * uint(CLASSES) + uint(CLASS)) * argument_words + 3u];
  uint list = lists.x * uint(tile_dimension.x * tile_dimension.y) + first[CLASS];
  for (uint slot = gl_WorkGroupID.x; slot < count; slot += gl_NumWorkGroups.x) {
    int tile_number = int(tiles[list + slot]);
    ivec2 tile = ivec2(tile_number % tile_dimension.x, tile_number / tile_dimension.x);
    int seen_from = sweep_tile(tile, int(gl_LocalInvocationID.x), dimension, penalty,
                               Sweep(turn.x, turn.y, turn.z, turn.w));
    if (ACTIVE) {
      wake(tile, seen_from, tile_dimension, lists.y, lists.z, first);
    }
  }
}
