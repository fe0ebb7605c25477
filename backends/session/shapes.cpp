#include "backends/session/shapes.hpp"

#include <algorithm>
#include <cstdint>

namespace hdmbench {

namespace {

/// There is a shape for each kind of device. Commit d76da19, which still measured shapes, compared those for
/// CPUs with nine others on Mesa's rasterizers and with five on PoCL, on one AMD EPYC at 512 x 512: llvmpipe
/// and PoCL have the fastest, lavapipe's takes 10 % longer than the fastest. Coarse levels are computed
/// fastest there by a group of 8, one vector, because a CPU puts each vector aside at a barrier (lavapipe, 8,
/// 64, 256, 1024 invocations: 1.2, 1.3, 1.7, 3.3 ms).
/// A GPU wants many invocations with little to do each. Measured on an NVIDIA H200 by changing this table and
/// `bench square --work dense` (`bench ball` for the volume): 1200 x 1200, all sweeps, tiles of 16, 8,
/// 4, 2 and 1 rows: CUDA 6.7, 5.4, 4.7, 4.6, 4.9 ms, Vulkan 4.8, 4.4, 4.2, 4.5, 4.3 ms; at 300 x 300
/// CUDA 4.3, 3.1, 2.6, 2.5, 2.6 ms; a volume of 64 x 64 x 64 with 16, 4 and 1 rows 10.9, 8.2, 9.4 ms.
constexpr Shapes shaders_on_cpu{.sweep = {.tile = {32, 16}, .columns = 2, .tiles_a_group = 64},
                                .coarse_group = 8};
constexpr Shapes shaders_on_gpu{.sweep = {{64, 4}, 1}, .coarse_group = 256};
constexpr Shapes opencl_on_cpu{.sweep = {{64, 32}, 64, 16}}; // one work item a group
constexpr Shapes opencl_on_gpu{.sweep = {{64, 4}, 1}};

/// Of the largest level that is computed with others, and the shared memory that the work group then needs,
/// bytes.
constexpr std::size_t most_coarse_sites = 32 * 32;
constexpr std::size_t coarse_shared_bytes = most_coarse_sites * (2 * 8 + 8 + 4) + 3 * 4;

/// Of all loops of an invocation together. llvmpipe leaves them without a word after 65,535; it also keeps
/// the dispatch below the watchdogs of drivers.
constexpr std::int64_t most_turns = 60'000;

/// Of a level by a group, at most: a site takes one of the loop over sites and two of that over a tile's
/// rows, a sweep three more (counted on llvmpipe: four to be safe). To sample and to store take no more than
/// two sweeps.
std::int64_t turns(const PyramidLevel& level, int group) {
  const auto sites = static_cast<std::int64_t>(level.extent.sites());
  return (3 * ((sites + group - 1) / group) + 4) * (level.sweeps + 2);
}

} // namespace

Shapes shapes_for(const ComputeDevice& device) {
  const DeviceLimits& limits = device.limits();
  const bool is_cpu = device.description().is_software;
  if (limits.has_planes) {
    return is_cpu || limits.group < opencl_on_gpu.sweep.invocations() ? opencl_on_cpu : opencl_on_gpu;
  }
  Shapes shapes = is_cpu ? shaders_on_cpu : shaders_on_gpu;
  shapes.coarse_group =
      limits.shared_bytes < coarse_shared_bytes ? 0 : std::min(shapes.coarse_group, limits.group);
  return shapes;
}

std::size_t coarse_level_count(const Pyramid& pyramid, int group) {
  if (group == 0 || pyramid.full->extent.axes() > 2 || !changes_spread_by_contact(*pyramid.full)) {
    return 0;
  }
  std::size_t count = 0;
  std::int64_t turns_so_far = 0;
  while (count + 1 < pyramid.levels.size() && pyramid.levels[count].extent.sites() <= most_coarse_sites) {
    turns_so_far += turns(pyramid.levels[count], group);
    if (turns_so_far > most_turns) {
      break;
    }
    ++count;
  }
  return count;
}

} // namespace hdmbench
