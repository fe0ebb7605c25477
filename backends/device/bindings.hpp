#pragma once

#include <cstddef>

/// Where compute shaders find their arrays, as their layout(binding = ...) has it. The number says what is
/// done to an array, so that an API with kinds of its own for that needs no table: of Vulkan all are in one
/// set, of OpenGL they are units of images, binding points of storage buffers and units of textures. A
/// compiler of OpenCL C gets those that a kernel has as its arguments.
namespace hdmbench::binding {

/// Texels that are stored to, words, and texels that are fetched.
constexpr std::size_t first_stored = 0;
constexpr std::size_t first_words = 4;
constexpr std::size_t first_fetched = 7;
constexpr std::size_t count = 16;

constexpr std::size_t improved = 0;
constexpr std::size_t sampled_material = 1;
constexpr std::size_t sampled_observation = 2;
constexpr std::size_t counter = 4;
constexpr std::size_t tiles = 4;
constexpr std::size_t lengths = 5;          ///< of the lists of tiles that a sweep reads
constexpr std::size_t appended_lengths = 6; ///< of those that it makes
constexpr std::size_t displacement = 7;
constexpr std::size_t material = 8;
constexpr std::size_t observation = 9;
constexpr std::size_t inverse_curvature = 10;
constexpr std::size_t entries = 11;
constexpr std::size_t inputs = 12;

/// Of the programs that measure and probe a device.
constexpr std::size_t target = 0;
constexpr std::size_t source = 7;

} // namespace hdmbench::binding
