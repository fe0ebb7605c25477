// What the shaders of a Vulkan session share: its buffers and what they are told. backends/vulkan/shaders.hpp has the
// same for C++. Texel buffers because software rasterizers read them several times faster than storage buffers.

layout(set = 0, binding = 0) uniform textureBuffer displacement;
layout(set = 0, binding = 1) uniform textureBuffer material;          // modulus, 1 / modulus
layout(set = 0, binding = 2) uniform textureBuffer observation;       // target x, y, confidence x, y
layout(set = 0, binding = 3) uniform textureBuffer inverse_curvature; // x, y, where the rule needs them
layout(set = 0, binding = 4, rg32f) uniform restrict imageBuffer improved;
layout(set = 0, binding = 5, std430) buffer Counter { uint changed; };

// The tiles of the level by their number, row by row, in sections of tile_count words: the class of each, the last
// sweep each was put on a list for, and per set of lists and class a list of tiles.
layout(set = 0, binding = 6, std430) buffer Tiles { uint tiles[]; };

// How long each list is (w), and the work groups to sweep it with (xyz, as vkCmdDispatchIndirect reads them).
layout(set = 0, binding = 7, std430) buffer Lengths { uvec4 lengths[]; };

layout(push_constant) uniform Parameters {
  float steps[16];
  float penalty;
  int width;
  int height;
  float colour; // this and the next three are update.inc's Sweep
  float strength;
  float number;
  float seed;
  int tiles_across;
  int tile_count;
  int list;        // the set of lists to sweep
  int length;      // its first class's element of lengths
  int next_list;   // the same for the list that changes are put on
  int next_length;
  int stamp;       // of this sweep, > 0, another one for each since the tiles were all asleep
};

const int class_count = 8; // of backends/tiles.hpp

// Sides of a tile in sites.
const ivec2 tile_size = ivec2(TILE_WIDTH, TILE_HEIGHT);

// Most work groups side by side in the dispatch of a list.
const uint most_groups_across = 4096u;

int index_of(ivec2 site) { return site.y * width + site.x; }

// Where the tiles of a list begin.
int list_begin(int set, int tile_class) { return (2 + set * class_count + tile_class) * tile_count; }

void append_tile(uint tile, int tile_class, int set, int first_length) {
  int at = first_length + tile_class;
  uint place = atomicAdd(lengths[at].w, 1u);
  tiles[list_begin(set, tile_class) + int(place)] = tile;
  if (place < most_groups_across) {
    atomicMax(lengths[at].x, place + 1u);
  }
  if (place % most_groups_across == 0u) {
    atomicAdd(lengths[at].y, 1u);
    lengths[at].z = 1u;
  }
}
