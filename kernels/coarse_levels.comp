#version 430
// The coarse levels of a pyramid, from the null field, by one work group.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise

// INVOCATIONS, STEP_COUNT and STOPS_AT_REST are supplied after #version.
layout(local_size_x = INVOCATIONS) in;

layout(binding = 0) uniform samplerBuffer entries;     // backends/resampling_entries.hpp
layout(binding = 1) uniform samplerBuffer material;    // rg: modulus, 1 / modulus
layout(binding = 2) uniform samplerBuffer observation; // rg: target, ba: confidence
layout(binding = 0, rg32f) uniform restrict writeonly imageBuffer improved;
layout(location = 0) uniform ivec2 levels; // where the table begins, number of levels
layout(location = 1) uniform int full_width;
layout(location = 2) uniform float penalty;
layout(location = 3) uniform float steps[16];
const int step_count = STEP_COUNT;
const bool stops_at_rest = STOPS_AT_REST;

#include "energy.inc"
#include "update.inc"
#include "projection.inc"

#include "coarse_levels.glsl"

void main() { solve_coarse_levels(int(gl_LocalInvocationID.x), levels.x, levels.y, full_width, penalty); }
