#pragma once

#include <cstdint>

/// Where compute shaders find their buffers, as their layout(binding = ...) has it: of Vulkan all in one set,
/// of OpenGL the units of textures and images and the binding points of storage buffers.
namespace hdmbench::binding {

constexpr std::uint32_t displacement = 0;
constexpr std::uint32_t material = 1;
constexpr std::uint32_t observation = 2;
constexpr std::uint32_t inverse_curvature = 3;
constexpr std::uint32_t improved = 4;
constexpr std::uint32_t counter = 5;
constexpr std::uint32_t tiles = 6;
constexpr std::uint32_t lengths = 7;
constexpr std::uint32_t entries = 8;
/// Of sample.comp; OpenGL has numbers of its own, there may be eight image units.
constexpr std::uint32_t sampled_material = 9;
constexpr std::uint32_t sampled_observation = 10;
constexpr std::uint32_t inputs = 11;
/// Of Vulkan: the lengths of the lists that a sweep makes; `lengths` are of those that it reads.
constexpr std::uint32_t appended_lengths = 12;
constexpr std::uint32_t count = 13;

} // namespace hdmbench::binding
