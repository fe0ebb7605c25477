#include "backends/vulkan/sweeps.hpp"

#include "backends/vulkan/vulkan_compute.hpp"

#include <algorithm>
#include <utility>

namespace hdmbench::vulkan {

namespace {

using Usage = vk::BufferUsageFlagBits;

constexpr vk::DeviceSize bytes_of_length = 4 * sizeof(std::uint32_t);
constexpr vk::DeviceSize bytes_of_lengths = class_count * bytes_of_length;

/// Element of the lengths of the list that sweep `since_write` reads; its first class's.
constexpr std::int32_t length_of(int since_write) {
  return static_cast<std::int32_t>(class_count) * (since_write % (most_recorded_sweeps + 1));
}
constexpr std::int32_t length_of_full =
    length_of(most_recorded_sweeps) + static_cast<std::int32_t>(class_count);

std::uint32_t divided(std::int32_t number, std::uint32_t by) {
  return (static_cast<std::uint32_t>(number) + by - 1) / by;
}

/// Few, as each is a dispatch of its own: where there is an interior, its tiles are told from those at the
/// border, and in dense work, most of which is theirs, from each other.
std::size_t classes_of(const Level& whole, Extent extent, const SweepShape& shape, bool active) {
  using namespace tile_class;
  const bool has_interior = extent.width > 3 * shape.tile.width && extent.height > 3 * shape.tile.height;
  if (!has_interior || !changes_spread_by_contact(whole)) {
    return class_set({});
  }
  return active ? class_set({observed_bit | elastic_bit}) : dense_classes;
}

} // namespace

TileGrid::TileGrid(Extent extent, const SweepShape& shape)
    : across(tiles_of(extent, shape.tile).width),
      count(static_cast<std::int32_t>(tiles_of(extent, shape.tile).sites())) {}

ListBuffers::ListBuffers(const Queue& queue, std::int32_t capacity_)
    : capacity(capacity_),
      tiles(queue.make_buffer(most_bytes(capacity), Usage::eStorageBuffer | Usage::eTransferDst,
                              Placement::device)),
      lengths(queue.make_buffer((most_recorded_sweeps + 2) * bytes_of_lengths,
                                Usage::eStorageBuffer | Usage::eIndirectBuffer | Usage::eTransferDst,
                                Placement::device)) {}

vk::DeviceSize ListBuffers::most_bytes(std::int32_t capacity) {
  const auto words = static_cast<vk::DeviceSize>(capacity) * tile_class::words_per_tile;
  return words * sizeof(std::uint32_t);
}

SweepPlan::SweepPlan(const Level& whole, Extent extent, std::vector<float> strengths, Work work,
                     const SweepShape& shape_)
    : level(without_fields(whole)), shape(shape_), grid(extent, shape_),
      active(work == Work::active && changes_spread_by_contact(whole)),
      classes(classes_of(whole, extent, shape_, active)) {
  level.extent = extent;
  level.strengths = std::move(strengths);
}

std::uint32_t groups_across(std::int32_t width) {
  return divided(width, invocations_per_group);
}

void wait_for_all(const vk::raii::CommandBuffer& commands) {
  using Stage = vk::PipelineStageFlagBits;
  using Access = vk::AccessFlagBits;
  const vk::PipelineStageFlags stages = Stage::eComputeShader | Stage::eTransfer | Stage::eDrawIndirect;
  barrier(commands, stages, Access::eShaderWrite | Access::eTransferWrite, stages,
          Access::eShaderRead | Access::eShaderWrite | Access::eTransferRead | Access::eTransferWrite |
              Access::eIndirectCommandRead);
}

Parameters SweepRecorder::parameters() const {
  return {.steps = plan_.level.steps.padded(),
          .penalty = plan_.level.penalty,
          .width = plan_.level.extent.width,
          .height = plan_.level.extent.height,
          .tiles_across = plan_.grid.across,
          .tile_count = plan_.grid.count,
          .list = tile_class::full_set,
          .length = length_of_full,
          .first_input = plan_.first_input};
}

void SweepRecorder::bind(const vk::raii::Pipeline& pipeline) const {
  commands_.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
}

template <typename Values>
void SweepRecorder::bind(const vk::raii::DescriptorSet& set, const Values& parameters) const {
  commands_.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *shaders_.layout(), 0, *set, {});
  commands_.pushConstants<Values>(*shaders_.layout(), vk::ShaderStageFlagBits::eCompute, 0, parameters);
}

void SweepRecorder::classify(const vk::raii::DescriptorSet& set) const {
  wait_for_all(commands_);
  commands_.fillBuffer(*lists_.lengths.handle, length_of_full * bytes_of_length, bytes_of_lengths, 0);
  wait_for_all(commands_);
  bind(shaders_.classify({plan_.classes, plan_.shape}));
  bind(set, parameters());
  const std::uint32_t groups = groups_across(plan_.grid.count);
  constexpr auto most = static_cast<std::uint32_t>(tile_class::most_groups_across);
  commands_.dispatch(std::min(groups, most), divided(static_cast<std::int32_t>(groups), most), 1);
}

void SweepRecorder::wake_all() const {
  wait_for_all(commands_);
  const vk::DeviceSize section = static_cast<vk::DeviceSize>(plan_.grid.count) * sizeof(std::uint32_t);
  commands_.fillBuffer(*lists_.tiles.handle, tile_class::stamps_section * section, section, 0);
}

void SweepRecorder::clear_lengths(int since_write) const {
  wait_for_all(commands_);
  const vk::DeviceSize kept = static_cast<vk::DeviceSize>(length_of(since_write)) * bytes_of_length;
  const vk::DeviceSize end = static_cast<vk::DeviceSize>(length_of_full) * bytes_of_length;
  if (kept > 0) {
    commands_.fillBuffer(*lists_.lengths.handle, 0, kept, 0);
  }
  if (kept + bytes_of_lengths < end) {
    commands_.fillBuffer(*lists_.lengths.handle, kept + bytes_of_lengths, end - kept - bytes_of_lengths, 0);
  }
}

void SweepRecorder::sweep(const vk::raii::DescriptorSet& set, int number, int since_write) const {
  Parameters all = parameters();
  all.turn = sweep_state(plan_.level, number);
  if (plan_.active) {
    if (since_write > 0) {
      all.list = since_write % 2;
      all.length = length_of(since_write);
    }
    all.next_list = (since_write + 1) % 2;
    all.next_length = length_of(since_write + 1);
    all.stamp = since_write + 1;
  }
  wait_for_all(commands_);
  bind(set, all);
  bool is_first = true;
  for (std::size_t tile_class = 0; tile_class < class_count; ++tile_class) {
    if ((plan_.classes >> tile_class & 1) == 0) {
      continue;
    }
    // Nothing to wait for between the classes of a sweep: they write different sites, and append to other
    // lists than they read. In active work the validation layer takes the appended lengths for those that the
    // next class's dispatch reads, which are other elements of the buffer; dense work writes none.
    if (plan_.active && !std::exchange(is_first, false)) {
      wait_for_all(commands_);
    }
    bind(shaders_.sweep({.constants = shader_constants(plan_.level),
                         .tile_class = tile_class,
                         .shape = plan_.shape,
                         .wakes = plan_.active}));
    const auto length = static_cast<vk::DeviceSize>(all.length) + tile_class;
    commands_.dispatchIndirect(*lists_.lengths.handle, length * bytes_of_length);
  }
}

void SweepRecorder::count(const vk::raii::DescriptorSet& set) const {
  wait_for_all(commands_);
  bind(shaders_.count());
  bind(set, Count{plan_.level.extent.width});
  commands_.dispatch(groups_across(plan_.level.extent.width),
                     static_cast<std::uint32_t>(plan_.level.extent.height), 1);
}

} // namespace hdmbench::vulkan
