#version 450
#extension GL_GOOGLE_include_directive : require

// The coarse levels of a pyramid, from the null field, by one work group.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const int step_count = 1;
layout(constant_id = 2) const bool stops_at_rest = false;
const int INVOCATIONS = int(gl_WorkGroupSize.x);

// As in resampling.vulkan.glsl.
layout(set = 0, binding = 1) uniform textureBuffer material;
layout(set = 0, binding = 2) uniform textureBuffer observation;
layout(set = 0, binding = 4, rg32f) uniform restrict writeonly imageBuffer improved;
layout(set = 0, binding = 8) uniform textureBuffer entries;

layout(push_constant) uniform Coarse { // backends/vulkan/shaders.hpp has the same for C++
  float steps[16];
  float penalty;
  int full_width;
  int first_level;
  int level_count;
};

#include "energy.inc"
#include "update.inc"
#include "projection.inc"

#include "coarse_levels.glsl"

void main() {
  solve_coarse_levels(int(gl_LocalInvocationID.x), first_level, level_count, full_width, penalty);
}
