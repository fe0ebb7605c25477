// What the compute shaders of OpenGL and Vulkan have in common, in one text for both: where a level's fields are bound
// (backends/device/device.hpp has the same numbers), and how a shader is told words, and numbers after them:
//
//   PARAMETERS(count)             int parameters[count]
//   PARAMETERS_AND_STEPS(count)   and float steps[16], unless STEPS has the candidates as constants: a tenth faster
//
// are uniforms or push constants. Texel buffers because software rasterizers read them several times faster than storage
// buffers.

#ifdef VULKAN
#define samplerBuffer textureBuffer
#define PARAMETERS(count) layout(push_constant) uniform Parameters { int parameters[count]; };
#define PARAMETERS_AND_STEPS(count) layout(push_constant) uniform Parameters { int parameters[count]; float steps[16]; };
#else
#define PARAMETERS(count) layout(location = 0) uniform int parameters[count];
#ifdef STEPS
#define PARAMETERS_AND_STEPS(count) PARAMETERS(count) const float steps[16] = float[16](STEPS);
#else
#define PARAMETERS_AND_STEPS(count) PARAMETERS(count) layout(location = 32) uniform float steps[16];
#endif
#endif

#include "axes.glsl"

layout(binding = 0, TEXELS) uniform restrict imageBuffer improved;
layout(binding = 7) uniform samplerBuffer displacement;
layout(binding = 8) uniform samplerBuffer material;    // modulus, 1 / modulus
layout(binding = 9) uniform samplerBuffer observation; // target and confidence: of a volume a texel each
layout(binding = 11) uniform samplerBuffer entries;    // backends/session/level_arrays.hpp
layout(binding = 12) uniform samplerBuffer inputs;     // the energy's own, of all levels one after the other

#if HDM_AXES > 2
Vector target_of(int i) { return texelFetch(observation, 2 * i).xyz; }
Vector confidence_of(int i) { return texelFetch(observation, 2 * i + 1).xyz; }
#else
Vector target_of(int i) { return texelFetch(observation, i).xy; }
Vector confidence_of(int i) { return texelFetch(observation, i).zw; }
#endif
