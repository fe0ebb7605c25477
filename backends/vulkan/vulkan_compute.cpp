#include "backends/vulkan/vulkan_compute.hpp"

#include "backends/session/device_backend.hpp"
#include "backends/shared/energy_programs.hpp"
#include "backends/vulkan/compute_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace hdmbench::vulkan {

namespace {

// SPIR-V, as arrays count_vulkan and so on.
#include <shaders/ceiling_copy_vulkan.hpp>
#include <shaders/ceiling_multiply_add_vulkan.hpp>
#include <shaders/count_vulkan.hpp>
#include <shaders/elastic_coarse_vulkan.hpp>
#include <shaders/elastic_vulkan.hpp>
#include <shaders/probe_vulkan.hpp>
#include <shaders/project_vulkan.hpp>
#include <shaders/sample_vulkan.hpp>

using Usage = vk::BufferUsageFlagBits;
using Stage = vk::PipelineStageFlagBits;
using Access = vk::AccessFlagBits;

constexpr vk::DeviceSize staging_bytes = vk::DeviceSize{16} << 20;
constexpr std::uint32_t bytes_told = 128; ///< of push constants, as every device has them
/// More combinations of arrays than the levels of a session make.
constexpr std::uint32_t most_sets = 1024;

std::span<const std::uint32_t> text_of(const ProgramKind& kind) {
  switch (kind.kernel) {
  case Kernel::sweep:
    return programs_of(*kind.energy).vulkan_sweep;
  case Kernel::count:
    return count_vulkan;
  case Kernel::sample:
    return sample_vulkan;
  case Kernel::project:
    return project_vulkan;
  case Kernel::coarse_levels:
    return programs_of(*kind.energy).vulkan_coarse_levels;
  case Kernel::elastic:
    return elastic_vulkan;
  case Kernel::elastic_coarse:
    return elastic_coarse_vulkan;
  case Kernel::probe:
    return probe_vulkan;
  case Kernel::copy:
    return ceiling_copy_vulkan;
  case Kernel::multiply_add:
    return ceiling_multiply_add_vulkan;
  }
  return {};
}

vk::Format format_of(Kind kind) {
  return kind == Kind::pairs ? vk::Format::eR32G32Sfloat : vk::Format::eR32G32B32A32Sfloat;
}

vk::DescriptorType type_of(std::size_t number) {
  return number < binding::first_words     ? vk::DescriptorType::eStorageTexelBuffer
         : number < binding::first_fetched ? vk::DescriptorType::eStorageBuffer
                                           : vk::DescriptorType::eUniformTexelBuffer;
}

vk::raii::DescriptorSetLayout make_set_layout(const vk::raii::Device& device) {
  std::array<vk::DescriptorSetLayoutBinding, binding::count> bindings;
  for (std::uint32_t i = 0; i < binding::count; ++i) {
    bindings[i] = {i, type_of(i), 1, vk::ShaderStageFlagBits::eCompute};
  }
  return {device, vk::DescriptorSetLayoutCreateInfo({}, bindings)};
}

vk::raii::PipelineLayout make_layout(const vk::raii::Device& device,
                                     const vk::raii::DescriptorSetLayout& set_layout) {
  const vk::PushConstantRange told(vk::ShaderStageFlagBits::eCompute, 0, bytes_told);
  return {device, vk::PipelineLayoutCreateInfo({}, *set_layout, told)};
}

vk::raii::DescriptorPool make_pool(const vk::raii::Device& device) {
  constexpr std::uint32_t stored = binding::first_words - binding::first_stored;
  constexpr std::uint32_t words = binding::first_fetched - binding::first_words;
  constexpr std::uint32_t fetched = binding::count - binding::first_fetched;
  const std::array sizes{
      vk::DescriptorPoolSize(vk::DescriptorType::eStorageTexelBuffer, stored * most_sets),
      vk::DescriptorPoolSize(vk::DescriptorType::eStorageBuffer, words * most_sets),
      vk::DescriptorPoolSize(vk::DescriptorType::eUniformTexelBuffer, fetched * most_sets)};
  return {device, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                               most_sets, sizes)};
}

/// Throws DeviceError where the device lacks a format or a feature that Vulkan leaves optional.
void require_texel_buffers(const vk::raii::PhysicalDevice& physical) {
  using Feature = vk::FormatFeatureFlagBits;
  for (const vk::Format format : {format_of(Kind::pairs), format_of(Kind::fours)}) {
    const vk::FormatFeatureFlags needed = Feature::eUniformTexelBuffer | Feature::eStorageTexelBuffer;
    const vk::FormatFeatureFlags found = physical.getFormatProperties(format).bufferFeatures;
    if ((found & needed) != needed) {
      throw DeviceError(fmt::format("{}: buffers of {} can only be {}, the sweep needs {}",
                                    describe(physical).name, vk::to_string(format), vk::to_string(found),
                                    vk::to_string(needed)));
    }
  }
  if (physical.getFeatures().shaderStorageImageExtendedFormats == VK_FALSE) {
    throw DeviceError(
        fmt::format("{}: has no shaderStorageImageExtendedFormats, which rg32f in a shader needs",
                    describe(physical).name));
  }
}

vk::PhysicalDeviceFeatures needed_features() {
  vk::PhysicalDeviceFeatures features;
  features.shaderStorageImageExtendedFormats = VK_TRUE;
  return features;
}

DeviceLimits limits_of(const Queue& queue) {
  const vk::PhysicalDeviceLimits limits = queue.physical().getProperties().limits;
  const auto chain =
      queue.physical()
          .getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceMaintenance3Properties>();
  const auto largest_index = static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
  return {.elements = std::min(limits.maxTexelBufferElements, largest_index),
          .array_bytes = chain.get<vk::PhysicalDeviceMaintenance3Properties>().maxMemoryAllocationSize,
          .memory = queue.heap_bytes(Placement::device),
          .groups_x = limits.maxComputeWorkGroupCount[0],
          .groups_y = limits.maxComputeWorkGroupCount[1],
          .group = static_cast<int>(
              std::min({limits.maxComputeWorkGroupInvocations, limits.maxComputeWorkGroupSize[0], 1024U})),
          .shared_bytes = limits.maxComputeSharedMemorySize};
}

class VulkanProgram final : public Program {
public:
  explicit VulkanProgram(vk::raii::Pipeline made) : pipeline(std::move(made)) {}

  vk::raii::Pipeline pipeline;
};

class VulkanRecording final : public Recording {
public:
  explicit VulkanRecording(vk::raii::CommandBuffer recorded) : Recording({}), commands(std::move(recorded)) {}

  vk::raii::CommandBuffer commands;
};

class VulkanDevice;

class VulkanArray final : public Array {
public:
  VulkanArray(VulkanDevice& device, const Queue& queue, std::size_t count, Kind kind);
  VulkanArray(const VulkanArray&) = delete;
  VulkanArray& operator=(const VulkanArray&) = delete;
  ~VulkanArray() override;

  Buffer buffer;
  vk::raii::BufferView view = nullptr; ///< of texels

private:
  VulkanDevice& device_;
};

const VulkanArray& of(const Array& array) {
  return static_cast<const VulkanArray&>(array);
}

/// Commands are recorded as they come and submitted by finish(), all at once.
class VulkanDevice final : public ComputeDevice {
public:
  explicit VulkanDevice(Queue queue)
      : queue_(std::move(queue)), description_(describe(queue_.physical())), limits_(limits_of(queue_)),
        staging_(
            queue_.make_buffer(staging_bytes, Usage::eTransferSrc | Usage::eTransferDst, Placement::host)),
        staged_(static_cast<std::byte*>(staging_.memory.mapMemory(0, VK_WHOLE_SIZE))),
        set_layout_(make_set_layout(queue_.device())), layout_(make_layout(queue_.device(), set_layout_)),
        pool_(make_pool(queue_.device())) {}

  const Device& description() const override { return description_; }
  const DeviceLimits& limits() const override { return limits_; }

  void write(const Array& to, std::size_t first, std::span<const std::byte> values) override {
    guarded([&] {
      flush();
      for (std::size_t done = 0; done < values.size(); done += staging_bytes) {
        const std::size_t bytes = std::min<std::size_t>(values.size() - done, staging_bytes);
        std::memcpy(staged_, values.data() + done, bytes);
        queue_.submit([&](const vk::raii::CommandBuffer& commands) {
          commands.copyBuffer(*staging_.handle, *of(to).buffer.handle,
                              vk::BufferCopy(0, first + done, bytes));
        });
      }
    });
  }
  void read(const Array& from, std::size_t first, std::span<std::byte> values) override {
    guarded([&] {
      flush();
      for (std::size_t done = 0; done < values.size(); done += staging_bytes) {
        const std::size_t bytes = std::min<std::size_t>(values.size() - done, staging_bytes);
        queue_.submit([&](const vk::raii::CommandBuffer& commands) {
          commands.copyBuffer(*of(from).buffer.handle, *staging_.handle,
                              vk::BufferCopy(first + done, 0, bytes));
          barrier(commands, Stage::eTransfer, Access::eTransferWrite, Stage::eHost, Access::eHostRead);
        });
        std::memcpy(values.data() + done, staged_, bytes);
      }
    });
  }
  std::unique_ptr<Program> compile(const ProgramKind& kind) override {
    return guarded([&] {
      std::vector<std::int32_t> values;
      std::ranges::transform(kind.constants, std::back_inserter(values), &ProgramKind::Constant::value);
      return std::make_unique<VulkanProgram>(make_pipeline(queue_.device(), layout_, text_of(kind), values));
    });
  }
  void run(std::span<const Commands::value_type> commands) override {
    guarded([&] {
      if (!recording_) {
        recording_ = queue_.begin_recording();
      }
      append(*recording_, commands);
    });
  }
  void finish() override {
    guarded([&] { flush(); });
  }
  std::unique_ptr<Recording> record(Commands commands) override {
    return guarded([&] {
      vk::raii::CommandBuffer recorded = queue_.begin_recording();
      append(recorded, commands);
      recorded.end();
      return std::make_unique<VulkanRecording>(std::move(recorded));
    });
  }
  void replay(const Recording& recording) override {
    guarded([&] {
      flush();
      queue_.submit(static_cast<const VulkanRecording&>(recording).commands);
    });
  }

  /// No set may keep what is gone, even at a binding that no shader reads: lavapipe (Mesa 22.3) hands its
  /// context all of a set at each dispatch, used or not.
  void forget(const Array& array) noexcept {
    try {
      flush();
    } catch (const std::exception&) { // what was recorded is lost with the array
    }
    std::erase_if(sets_, [&](const auto& set) { return std::ranges::count(set.first, &array) > 0; });
  }

private:
  /// call(), after whose error nothing is left that was recorded.
  template <typename Call>
  auto guarded(const Call& call) -> decltype(call()) {
    try {
      return translate_errors(call);
    } catch (...) {
      recording_.reset();
      throw;
    }
  }

  std::unique_ptr<Array> make(std::size_t count, Kind kind) override {
    return guarded([&] { return std::make_unique<VulkanArray>(*this, queue_, count, kind); });
  }

  void flush() {
    if (recording_) {
      const vk::raii::CommandBuffer commands = std::move(*recording_);
      recording_.reset();
      commands.end();
      queue_.submit(commands);
    }
  }

  void append(const vk::raii::CommandBuffer& to, std::span<const Commands::value_type> commands) {
    for (const auto& command : commands) {
      std::visit(
          [&](const auto& one) {
            if (!one.beside) {
              const vk::PipelineStageFlags stages =
                  Stage::eComputeShader | Stage::eTransfer | Stage::eDrawIndirect;
              barrier(to, stages, Access::eShaderWrite | Access::eTransferWrite, stages,
                      Access::eShaderRead | Access::eShaderWrite | Access::eTransferRead |
                          Access::eTransferWrite | Access::eIndirectCommandRead);
            }
            append(to, one);
          },
          command);
    }
  }
  void append(const vk::raii::CommandBuffer& to, const Dispatch& dispatch) {
    to.bindPipeline(vk::PipelineBindPoint::eCompute,
                    *static_cast<const VulkanProgram&>(*dispatch.program).pipeline);
    to.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout_, 0, *set_of(dispatch.arrays), {});
    std::array<std::int32_t, bytes_told / 4> told{};
    std::size_t count = dispatch.word_count;
    std::copy_n(dispatch.words.begin(), count, told.begin());
    if (dispatch.step_count > 0) {
      std::memcpy(&told.at(count), dispatch.steps.data(), sizeof dispatch.steps);
      count += dispatch.steps.size();
    }
    if (count > 0) {
      to.pushConstants<std::int32_t>(*layout_, vk::ShaderStageFlagBits::eCompute, 0,
                                     vk::ArrayProxy(static_cast<std::uint32_t>(count), told.data()));
    }
    if (dispatch.counted == nullptr) {
      to.dispatch(static_cast<std::uint32_t>(dispatch.groups.width),
                  static_cast<std::uint32_t>(dispatch.groups.height), 1);
    } else {
      to.dispatchIndirect(*of(*dispatch.counted).buffer.handle, dispatch.first_count * sizeof(std::uint32_t));
    }
  }
  static void append(const vk::raii::CommandBuffer& to, const Fill& fill) {
    to.fillBuffer(*of(*fill.array).buffer.handle, fill.first, fill.bytes, 0);
  }

  const vk::raii::DescriptorSet& set_of(const std::array<const Array*, binding::count>& arrays) {
    auto found = sets_.find(arrays);
    if (found == sets_.end()) {
      auto made = queue_.device().allocateDescriptorSets({*pool_, *set_layout_});
      found = sets_.emplace(arrays, std::move(made.front())).first;
      for (std::uint32_t number = 0; number < binding::count; ++number) {
        if (arrays[number] != nullptr) {
          const VulkanArray& array = of(*arrays[number]);
          const vk::BufferView view = *array.view;
          const vk::DescriptorBufferInfo whole(*array.buffer.handle, 0, VK_WHOLE_SIZE);
          vk::WriteDescriptorSet write(*found->second, number, 0, 1, type_of(number));
          write.setPTexelBufferView(&view).setPBufferInfo(&whole);
          queue_.device().updateDescriptorSets(write, {});
        }
      }
    }
    return found->second;
  }

  Queue queue_;
  Device description_;
  DeviceLimits limits_;
  Buffer staging_;
  std::byte* staged_; ///< staging_, mapped for as long as it lives
  vk::raii::DescriptorSetLayout set_layout_;
  vk::raii::PipelineLayout layout_;
  vk::raii::DescriptorPool pool_;
  std::map<std::array<const Array*, binding::count>, vk::raii::DescriptorSet> sets_;
  std::optional<vk::raii::CommandBuffer> recording_;
};

VulkanArray::VulkanArray(VulkanDevice& device, const Queue& queue, std::size_t count, Kind kind)
    : Array(device, count, kind), device_(device) {
  const vk::BufferUsageFlags usage = kind == Kind::words
                                         ? Usage::eStorageBuffer | Usage::eIndirectBuffer
                                         : Usage::eUniformTexelBuffer | Usage::eStorageTexelBuffer;
  buffer = queue.make_buffer(bytes(), usage | Usage::eTransferSrc | Usage::eTransferDst, Placement::device);
  if (kind != Kind::words) {
    view = queue.device().createBufferView({{}, *buffer.handle, format_of(kind), 0, bytes()});
  }
}

VulkanArray::~VulkanArray() {
  device_.forget(*this);
}

class VulkanApi final : public ComputeApi {
public:
  [[nodiscard]] std::vector<Device> devices() const override {
    return translate_errors([] {
      const Installation installation;
      std::vector<Device> all;
      for (const auto& device : installation.compute_devices()) {
        all.push_back(describe(device.physical));
      }
      return all;
    });
  }

  [[nodiscard]] std::unique_ptr<ComputeDevice> open(std::size_t index) const override {
    return translate_errors([&] {
      Installation installation;
      const auto devices = installation.compute_devices();
      if (index >= devices.size()) {
        throw DeviceError(fmt::format("Vulkan device {} has gone, {} are left", index, devices.size()));
      }
      require_texel_buffers(devices[index].physical);
      return std::make_unique<VulkanDevice>(
          Queue(std::move(installation), devices[index], needed_features()));
    });
  }
};

} // namespace

} // namespace hdmbench::vulkan

namespace hdmbench {

std::unique_ptr<Backend> make_vulkan_compute() {
  return make_device_backend({.name = "vulkan-compute",
                              .description = "GLSL 4.50 compute shader (SPIR-V), Vulkan 1.1, texel buffers",
                              .language = "GLSL 4.50, compute, SPIR-V"},
                             std::make_unique<vulkan::VulkanApi>());
}

} // namespace hdmbench
