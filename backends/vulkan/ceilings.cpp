#include "backends/vulkan/ceilings.hpp"

#include "backends/shared/ceiling_shaders.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace hdmbench::vulkan {

namespace {

// SPIR-V, as arrays ceiling_copy_vulkan and ceiling_multiply_add_vulkan.
#include <shaders/ceiling_copy_vulkan.hpp>
#include <shaders/ceiling_multiply_add_vulkan.hpp>

constexpr std::uint32_t group_size = 64; // local_size_x of the shaders
constexpr vk::Format format = vk::Format::eR32G32B32A32Sfloat;

vk::raii::DescriptorSetLayout make_set_layout(const vk::raii::Device& device) {
  const std::array bindings{vk::DescriptorSetLayoutBinding(0, vk::DescriptorType::eUniformTexelBuffer, 1,
                                                           vk::ShaderStageFlagBits::eCompute),
                            vk::DescriptorSetLayoutBinding(1, vk::DescriptorType::eStorageTexelBuffer, 1,
                                                           vk::ShaderStageFlagBits::eCompute)};
  return {device, vk::DescriptorSetLayoutCreateInfo({}, bindings)};
}

vk::raii::DescriptorPool make_pool(const vk::raii::Device& device) {
  const std::array sizes{vk::DescriptorPoolSize(vk::DescriptorType::eUniformTexelBuffer, 1),
                         vk::DescriptorPoolSize(vk::DescriptorType::eStorageTexelBuffer, 1)};
  return {device,
          vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 1, sizes)};
}

class Loops {
public:
  explicit Loops(Queue queue)
      : queue_(std::move(queue)),
        texels_(std::min<std::size_t>(
            bytes_to_copy() / ceiling_shaders::texel_bytes,
            std::bit_floor(queue_.physical().getProperties().limits.maxTexelBufferElements))),
        given_(ceiling_shaders::source(texels_)),
        host_(queue_.make_buffer(bytes(texels_), Usage::eTransferSrc | Usage::eTransferDst, Placement::host)),
        mapped_(static_cast<float*>(host_.memory.mapMemory(0, VK_WHOLE_SIZE))),
        source_(queue_.make_buffer(bytes(texels_), Usage::eUniformTexelBuffer | Usage::eTransferDst,
                                   Placement::device)),
        target_(queue_.make_buffer(bytes(texels_), Usage::eStorageTexelBuffer | Usage::eTransferSrc,
                                   Placement::device)),
        source_view_(queue_.device(),
                     vk::BufferViewCreateInfo({}, *source_.handle, format, 0, VK_WHOLE_SIZE)),
        target_view_(queue_.device(),
                     vk::BufferViewCreateInfo({}, *target_.handle, format, 0, VK_WHOLE_SIZE)),
        set_layout_(make_set_layout(queue_.device())), pool_(make_pool(queue_.device())),
        sets_(queue_.device().allocateDescriptorSets({*pool_, *set_layout_})),
        layout_(queue_.device(), vk::PipelineLayoutCreateInfo({}, *set_layout_)),
        copy_(make_pipeline(queue_.device(), layout_, ceiling_copy_vulkan, {})),
        multiply_add_(make_pipeline(queue_.device(), layout_, ceiling_multiply_add_vulkan, {})) {
    if (texels_ < ceiling_shaders::texels) {
      throw TooLarge("texel buffers end at 65536 texels or little more");
    }
    const vk::BufferView source = *source_view_;
    const vk::BufferView target = *target_view_;
    queue_.device().updateDescriptorSets(
        {vk::WriteDescriptorSet(*sets_.front(), 0, 0, vk::DescriptorType::eUniformTexelBuffer, {}, {},
                                source),
         vk::WriteDescriptorSet(*sets_.front(), 1, 0, vk::DescriptorType::eStorageTexelBuffer, {}, {},
                                target)},
        {});
    std::ranges::copy(given_, mapped_);
    queue_.submit([&](const vk::raii::CommandBuffer& commands) {
      commands.copyBuffer(*host_.handle, *source_.handle, vk::BufferCopy(0, 0, bytes(texels_)));
    });
  }

  [[nodiscard]] Ceilings measure() const {
    Ceilings ceilings;
    ceilings.copy_bytes_per_second = sample_rates(2.0 * static_cast<double>(bytes(texels_)),
                                                  [&](int times) { run(copy_, texels_, times); });
    ceiling_shaders::require_copied(given_, result(texels_));
    ceilings.operations_per_second = sample_rates(ceiling_shaders::operations(), [&](int times) {
      run(multiply_add_, ceiling_shaders::texels, times);
    });
    ceiling_shaders::require_computed(given_, result(ceiling_shaders::texels));
    return ceilings;
  }

private:
  using Usage = vk::BufferUsageFlagBits;
  using Stage = vk::PipelineStageFlagBits;
  using Access = vk::AccessFlagBits;

  [[nodiscard]] static vk::DeviceSize bytes(std::size_t texels) {
    return texels * ceiling_shaders::texel_bytes;
  }

  void run(const vk::raii::Pipeline& pipeline, std::size_t texels, int times) const {
    constexpr std::uint32_t groups_across = 1024;
    queue_.submit([&](const vk::raii::CommandBuffer& commands) {
      commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
      commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout_, 0, *sets_.front(), {});
      for (int i = 0; i < times; ++i) {
        commands.dispatch(groups_across, static_cast<std::uint32_t>(texels) / group_size / groups_across, 1);
        barrier(commands, Stage::eComputeShader, Access::eShaderWrite, Stage::eComputeShader,
                Access::eShaderWrite);
      }
    });
  }

  [[nodiscard]] std::span<const float> result(std::size_t texels) const {
    queue_.submit([&](const vk::raii::CommandBuffer& commands) {
      commands.copyBuffer(*target_.handle, *host_.handle, vk::BufferCopy(0, 0, bytes(texels)));
      barrier(commands, Stage::eTransfer, Access::eTransferWrite, Stage::eHost, Access::eHostRead);
    });
    return {mapped_, 4 * texels};
  }

  Queue queue_;
  std::size_t texels_;
  std::vector<float> given_;
  Buffer host_;
  float* mapped_; // host_, for as long as it lives
  Buffer source_;
  Buffer target_;
  vk::raii::BufferView source_view_;
  vk::raii::BufferView target_view_;
  vk::raii::DescriptorSetLayout set_layout_;
  vk::raii::DescriptorPool pool_;
  std::vector<vk::raii::DescriptorSet> sets_; // exactly one
  vk::raii::PipelineLayout layout_;
  vk::raii::Pipeline copy_;
  vk::raii::Pipeline multiply_add_;
};

} // namespace

Ceilings measure_ceilings(Installation installation, const Installation::ComputeDevice& chosen) {
  return Loops(Queue(std::move(installation), chosen, {})).measure();
}

} // namespace hdmbench::vulkan
