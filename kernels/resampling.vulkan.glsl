// How a level's sites lie in the full image and in the level computed before it. backends/vulkan/shaders.hpp has the
// same for C++.

layout(set = 0, binding = 0) uniform textureBuffer displacement;
layout(set = 0, binding = 1) uniform textureBuffer material;
layout(set = 0, binding = 2) uniform textureBuffer observation;
layout(set = 0, binding = 4, rg32f) uniform restrict writeonly imageBuffer improved;

// An entry per column, then one per row, of every level: the two coarse indices around it and the weight of the second
// (Interpolation of pyramid.hpp), and the index it samples of the full image. Exact, being below 2^24.
layout(set = 0, binding = 8) uniform textureBuffer entries;

layout(set = 0, binding = 9, rg32f) uniform restrict writeonly imageBuffer sampled_material;
layout(set = 0, binding = 10, rgba32f) uniform restrict writeonly imageBuffer sampled_observation;

layout(push_constant) uniform Resampling {
  int width; // of the level
  int from_width;
  int first_column; // of the level's entries
  int first_row;
};

vec4 column_entry(int column) { return texelFetch(entries, first_column + column); }
vec4 row_entry(int row) { return texelFetch(entries, first_row + row); }
