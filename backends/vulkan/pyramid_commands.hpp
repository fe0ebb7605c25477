#pragma once

#include "backends/shared/resampling_entries.hpp"
#include "backends/vulkan/sweeps.hpp"

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

/// A whole pyramid as commands of a Vulkan device.
namespace hdmbench::vulkan {

/// Keeps a submission short enough for the watchdogs of drivers: about a second at 10^8 sites a second. A
/// sweep counts as this many sites at least.
constexpr std::size_t updates_per_submission = std::size_t{1} << 27;
constexpr std::size_t least_updates_of_sweep = std::size_t{1} << 15;

/// The sites of the largest level that is sampled, not the full one; 0 where there is none.
[[nodiscard]] std::size_t most_sampled_sites(const Pyramid& pyramid);

/// What the commands work on. Changes to it end the commands' life.
struct PyramidBuffers {
  /// By fields (0: the full level's, 1: sampled) and by the displacement that is read.
  std::array<std::array<const vk::raii::DescriptorSet*, 2>, 2> sets{};
  const ListBuffers* lists = nullptr;
  std::vector<std::int32_t> first_inputs{};       ///< InputTexels::first
  const vk::raii::Buffer* displacement = nullptr; ///< that the sets [...][0] read
};

/// All levels from a null field, to be submitted in order, again and again.
struct PyramidCommands {
  struct Part {
    vk::raii::CommandBuffer commands;
    double site_updates;
  };
  std::vector<Part> parts;
  std::size_t newest = 0; ///< the displacement that has the solution afterwards
};

/// `coarse_group` of coarse_groups (backends/shared/coarse_levels.hpp).
[[nodiscard]] PyramidCommands record(const Pyramid& pyramid, const ResamplingEntries& entries, Work work,
                                     int coarse_group, const SweepShape& shape, const Queue& queue,
                                     Shaders& shaders, const PyramidBuffers& buffers);

} // namespace hdmbench::vulkan
