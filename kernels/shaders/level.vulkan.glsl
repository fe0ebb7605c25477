// What the shaders of a Vulkan session share: its buffers and what they are told. backends/vulkan/shaders.hpp has the
// same for C++. Texel buffers because software rasterizers read them several times faster than storage buffers.

layout(set = 0, binding = 0) uniform textureBuffer displacement;
layout(set = 0, binding = 1) uniform textureBuffer material;          // modulus, 1 / modulus
layout(set = 0, binding = 2) uniform textureBuffer observation;       // target x, y, confidence x, y
layout(set = 0, binding = 3) uniform textureBuffer inverse_curvature; // x, y, where the rule needs them
layout(set = 0, binding = 11) uniform textureBuffer inputs;           // the energy's own, where it has any
layout(set = 0, binding = 4, rg32f) uniform restrict imageBuffer improved;
layout(set = 0, binding = 5, std430) buffer Counter { uint changed; };

// As wake.glsl has them, and the last parameters too.
layout(set = 0, binding = 6, std430) buffer Tiles { uint tiles[]; };
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
  int list;
  int length;
  int next_list;
  int next_length;
  int stamp;
  int first_input; // texel of the level's first site
};

int index_of(ivec2 site) { return site.y * width + site.x; }
