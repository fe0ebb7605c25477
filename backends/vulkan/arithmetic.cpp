#include "backends/vulkan/arithmetic.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace hdmbench::vulkan {

namespace {

#include <shaders/probe_vulkan.hpp> // SPIR-V, as an array probe_vulkan

using Usage = vk::BufferUsageFlagBits;
using Type = vk::DescriptorType;

constexpr vk::Format format = vk::Format::eR32G32B32A32Sfloat;

} // namespace

std::vector<float> evaluate(Installation installation, const Installation::ComputeDevice& chosen,
                            std::span<const ArithmeticCase> cases) {
  const Queue queue(std::move(installation), chosen, {});
  const vk::raii::Device& device = queue.device();
  const vk::DeviceSize bytes = cases.size_bytes();
  const Buffer host = queue.make_buffer(bytes, Usage::eTransferSrc | Usage::eTransferDst, Placement::host);
  auto* const mapped = static_cast<float*>(host.memory.mapMemory(0, VK_WHOLE_SIZE));
  const Buffer source =
      queue.make_buffer(bytes, Usage::eUniformTexelBuffer | Usage::eTransferDst, Placement::device);
  const Buffer target =
      queue.make_buffer(bytes / 2, Usage::eStorageTexelBuffer | Usage::eTransferSrc, Placement::device);
  const vk::raii::BufferView source_view(device, {{}, *source.handle, format, 0, VK_WHOLE_SIZE});
  const vk::raii::BufferView target_view(device, {{}, *target.handle, format, 0, VK_WHOLE_SIZE});

  const auto stage = vk::ShaderStageFlagBits::eCompute;
  const std::array bindings{vk::DescriptorSetLayoutBinding(0, Type::eUniformTexelBuffer, 1, stage),
                            vk::DescriptorSetLayoutBinding(1, Type::eStorageTexelBuffer, 1, stage)};
  const vk::raii::DescriptorSetLayout set_layout(device, vk::DescriptorSetLayoutCreateInfo({}, bindings));
  const std::array sizes{vk::DescriptorPoolSize(Type::eUniformTexelBuffer, 1),
                         vk::DescriptorPoolSize(Type::eStorageTexelBuffer, 1)};
  const vk::raii::DescriptorPool pool(
      device, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 1, sizes));
  const std::vector<vk::raii::DescriptorSet> sets = device.allocateDescriptorSets({*pool, *set_layout});
  const vk::BufferView read = *source_view;
  const vk::BufferView written = *target_view;
  device.updateDescriptorSets(
      {vk::WriteDescriptorSet(*sets.front(), 0, 0, Type::eUniformTexelBuffer, {}, {}, read),
       vk::WriteDescriptorSet(*sets.front(), 1, 0, Type::eStorageTexelBuffer, {}, {}, written)},
      {});
  const vk::raii::PipelineLayout layout(device, vk::PipelineLayoutCreateInfo({}, *set_layout));
  const vk::raii::Pipeline pipeline = make_pipeline(device, layout, probe_vulkan, {});

  std::memcpy(mapped, cases.data(), bytes);
  queue.submit([&](const vk::raii::CommandBuffer& commands) {
    commands.copyBuffer(*host.handle, *source.handle, vk::BufferCopy(0, 0, bytes));
  });
  queue.submit([&](const vk::raii::CommandBuffer& commands) {
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
    commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout, 0, *sets.front(), {});
    commands.dispatch(static_cast<std::uint32_t>(cases.size() / cases_at_once), 1, 1);
  });
  queue.submit([&](const vk::raii::CommandBuffer& commands) {
    commands.copyBuffer(*target.handle, *host.handle, vk::BufferCopy(0, 0, bytes / 2));
    barrier(commands, vk::PipelineStageFlagBits::eTransfer, vk::AccessFlagBits::eTransferWrite,
            vk::PipelineStageFlagBits::eHost, vk::AccessFlagBits::eHostRead);
  });
  std::vector<float> results;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    results.push_back(mapped[4 * i]);
  }
  return results;
}

} // namespace hdmbench::vulkan
