// What the compute shaders of OpenGL and Vulkan have in common, in one text for both: where a level's fields are bound
// (backends/shared/shader_bindings.hpp has the same numbers), and how a shader declares its parameters:
//
//   PARAMETERS(Name)
//   PARAMETER(0) int width;
//   PARAMETERS_END
//
// are uniforms at these locations, or push constants one after the other. Texel buffers because software rasterizers read
// them several times faster than storage buffers.

#ifdef VULKAN
#define samplerBuffer textureBuffer
#define PARAMETERS(name) layout(push_constant) uniform name {
#define PARAMETER(place)
#define PARAMETERS_END };
#else
#define PARAMETERS(name)
#define PARAMETER(place) layout(location = place) uniform
#define PARAMETERS_END
#endif

layout(binding = 0) uniform samplerBuffer displacement;
layout(binding = 1) uniform samplerBuffer material;    // modulus, 1 / modulus
layout(binding = 2) uniform samplerBuffer observation; // target x, y, confidence x, y
layout(binding = 4, rg32f) uniform restrict imageBuffer improved;
layout(binding = 11) uniform samplerBuffer inputs;     // the energy's own, of all levels one after the other
layout(binding = 8) uniform samplerBuffer entries; // backends/shared/resampling_entries.hpp
