#include "backends/vulkan/vulkan_compute.hpp"

#include "backends/session/device_backend.hpp"
#include "backends/shared/kept_arithmetic.hpp"
#include "backends/vulkan/installation.hpp"
#include "backends/vulkan/spirv.hpp"

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

using Usage = vk::BufferUsageFlagBits;
using Stage = vk::PipelineStageFlagBits;
using Access = vk::AccessFlagBits;

constexpr const char* backend_name = "vulkan-compute";

/// More combinations of arrays than the levels of a session make.
constexpr std::uint32_t most_sets = 1024;

vk::raii::DescriptorPool make_set_pool(const vk::raii::Device& device) {
  std::array<vk::DescriptorPoolSize, binding::count> sizes;
  for (std::uint32_t i = 0; i < binding::count; ++i) {
    sizes[i] = {type_of(i), most_sets};
  }
  return {device, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                               most_sets, sizes)};
}

/// What the first dispatches or copies wrote becomes visible to those recorded after this.
void barrier(const vk::raii::CommandBuffer& commands, vk::PipelineStageFlags before, vk::AccessFlags written,
             vk::PipelineStageFlags after, vk::AccessFlags used) {
  commands.pipelineBarrier(before, after, {}, vk::MemoryBarrier(written, used), {}, {});
}

struct Buffer {
  vk::raii::DeviceMemory memory = nullptr; // first, so that it outlives the buffer bound to it
  vk::raii::Buffer handle = nullptr;
};

/// Where a buffer's memory lies.
enum class Placement {
  device, ///< the device's own memory, which the CPU may not be able to see
  host,   ///< visible to the CPU, coherent, cached by the CPU where the device has such memory
};

class VulkanProgram final : public Program {
public:
  explicit VulkanProgram(vk::raii::Pipeline made) : pipeline(std::move(made)) {}

  vk::raii::Pipeline pipeline;
};

class VulkanDevice;

class VulkanArray final : public Array {
public:
  VulkanArray(VulkanDevice& device, std::size_t count, Kind kind);
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
  VulkanDevice(std::shared_ptr<const Installation> installation, const FoundDevice& chosen)
      : installation_(std::move(installation)), description_(describe(chosen.physical)),
        memory_(chosen.physical.getMemoryProperties()), device_(make_device(chosen)),
        queue_(device_, chosen.queue_family, 0),
        command_pool_(device_, vk::CommandPoolCreateInfo({}, chosen.queue_family)),
        fence_(device_, vk::FenceCreateInfo()),
        staging_(make_buffer(staging_bytes, Usage::eTransferSrc | Usage::eTransferDst, Placement::host)),
        staged_(static_cast<std::byte*>(staging_.memory.mapMemory(0, VK_WHOLE_SIZE))),
        set_layout_(make_set_layout(device_)), layout_(make_layout(device_, set_layout_)),
        set_pool_(make_set_pool(device_)),
        clock_bits_(chosen.physical.getQueueFamilyProperties()[chosen.queue_family].timestampValidBits),
        tick_(1e-9 * static_cast<double>(chosen.physical.getProperties().limits.timestampPeriod)) {
    const vk::PhysicalDeviceLimits limits = chosen.physical.getProperties().limits;
    const auto chain =
        chosen.physical
            .getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceMaintenance3Properties>();
    const auto largest_index = static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
    const std::uint32_t heap =
        memory_.memoryTypes[memory_type(~std::uint32_t{0}, Placement::device)].heapIndex;
    limits_ = {.elements = std::min(limits.maxTexelBufferElements, largest_index),
               .array_bytes = chain.get<vk::PhysicalDeviceMaintenance3Properties>().maxMemoryAllocationSize,
               .memory = memory_.memoryHeaps[heap].size,
               .groups_x = limits.maxComputeWorkGroupCount[0],
               .groups_y = limits.maxComputeWorkGroupCount[1],
               .group = static_cast<int>(std::min(
                   {limits.maxComputeWorkGroupInvocations, limits.maxComputeWorkGroupSize[0], 1024U})),
               .shared_bytes = limits.maxComputeSharedMemorySize};
  }

  const Device& description() const override { return description_; }
  const DeviceLimits& limits() const override { return limits_; }

  void write(const Array& to, std::size_t first, std::span<const std::byte> values) override {
    guarded([&] {
      flush();
      for (std::size_t done = 0; done < values.size(); done += staging_bytes) {
        const std::size_t bytes = std::min(values.size() - done, staging_bytes);
        if (values.data() != staged_) {
          std::memcpy(staged_, values.data() + done, bytes);
        }
        const vk::raii::CommandBuffer commands = begin();
        commands.copyBuffer(*staging_.handle, *of(to).buffer.handle, vk::BufferCopy(0, first + done, bytes));
        commands.end();
        submit(commands);
      }
    });
  }
  void read(const Array& from, std::size_t first, std::span<std::byte> values) override {
    guarded([&] {
      flush();
      for (std::size_t done = 0; done < values.size(); done += staging_bytes) {
        const std::size_t bytes = std::min(values.size() - done, staging_bytes);
        const vk::raii::CommandBuffer commands = begin();
        commands.copyBuffer(*of(from).buffer.handle, *staging_.handle,
                            vk::BufferCopy(first + done, 0, bytes));
        barrier(commands, Stage::eTransfer, Access::eTransferWrite, Stage::eHost, Access::eHostRead);
        commands.end();
        submit(commands);
        if (values.data() != staged_) {
          std::memcpy(values.data() + done, staged_, bytes);
        }
      }
    });
  }
  std::unique_ptr<Program> compile(const ProgramKind& kind) override {
    return guarded([&] { return program_of(kind); });
  }
  std::vector<std::unique_ptr<Program>> compile_all(std::span<const ProgramKind> kinds) override {
    return guarded([&] {
      std::vector<std::unique_ptr<Program>> programs(kinds.size());
      on_all_threads(kinds.size(), kinds.size() > 1, [&](std::size_t i) {
        const KeptArithmetic kept(backend_name); // of this thread, which computes on the host, too
        programs[i] = program_of(kinds[i]);
      });
      return programs;
    });
  }
  ProgramText text_of(const ProgramKind& kind) const override {
    const Words text = spirv_of(kind);
    return {.bytes = {reinterpret_cast<const char*>(text.data()), text.size() * sizeof(std::uint32_t)},
            .ending = "spv"};
  }
  void run(std::span<const Commands::value_type> commands) override {
    guarded([&] {
      if (!recording_) {
        recording_ = begin();
        if (*times_ != vk::QueryPool()) {
          recording_->resetQueryPool(*times_, 0, 2);
          recording_->writeTimestamp(Stage::eBottomOfPipe, *times_, 0);
        }
      }
      append(*recording_, commands);
    });
  }
  void finish() override {
    guarded([&] { flush(); });
  }
  std::optional<double> device_seconds() override {
    finish();
    if (!busy_.are_counted() && clock_bits_ > 0) {
      times_ = translate_errors([&] { return device_.createQueryPool({{}, vk::QueryType::eTimestamp, 2}); });
    }
    return busy_.take();
  }
  std::span<std::byte> staging() override { return {staged_, staging_bytes}; }
  [[nodiscard]] const vk::raii::Device& device() const { return device_; }
  [[nodiscard]] Buffer make_buffer(vk::DeviceSize bytes, vk::BufferUsageFlags usage,
                                   Placement placement) const {
    Buffer buffer;
    buffer.handle = device_.createBuffer({{}, bytes, usage});
    const vk::MemoryRequirements requirements = buffer.handle.getMemoryRequirements();
    buffer.memory =
        device_.allocateMemory({requirements.size, memory_type(requirements.memoryTypeBits, placement)});
    buffer.handle.bindMemory(*buffer.memory, 0);
    return buffer;
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

  /// Several threads may call it. Throws what vk::raii throws.
  [[nodiscard]] std::unique_ptr<Program> program_of(const ProgramKind& kind) const {
    const Words text = spirv_of(kind);
    const vk::raii::ShaderModule module(device_, {{}, text.size() * sizeof(std::uint32_t), text.data()});
    const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main");
    return std::make_unique<VulkanProgram>(
        vk::raii::Pipeline(device_, nullptr, vk::ComputePipelineCreateInfo({}, stage, *layout_)));
  }

  std::unique_ptr<Array> make(std::size_t count, Kind kind) override {
    return guarded([&] { return std::make_unique<VulkanArray>(*this, count, kind); });
  }

  /// Among the types whose bit is set in `allowed`.
  [[nodiscard]] std::uint32_t memory_type(std::uint32_t allowed, Placement placement) const {
    using Flag = vk::MemoryPropertyFlagBits;
    const vk::MemoryPropertyFlags needed =
        placement == Placement::host ? Flag::eHostVisible | Flag::eHostCoherent : vk::MemoryPropertyFlags{};
    const vk::MemoryPropertyFlags wanted =
        placement == Placement::host ? Flag::eHostCached : Flag::eDeviceLocal;
    for (const vk::MemoryPropertyFlags flags : {needed | wanted, needed}) {
      for (std::uint32_t type = 0; type < memory_.memoryTypeCount; ++type) {
        const bool has_flags = (memory_.memoryTypes[type].propertyFlags & flags) == flags;
        if (has_flags && ((allowed >> type) & 1U) != 0) {
          return type;
        }
      }
    }
    throw DeviceError(fmt::format("Vulkan: no memory type is {}", vk::to_string(needed)));
  }

  /// A command buffer that is being recorded. What was submitted before is done and visible to it.
  [[nodiscard]] vk::raii::CommandBuffer begin() const {
    auto made = device_.allocateCommandBuffers({*command_pool_, vk::CommandBufferLevel::ePrimary, 1});
    made.front().begin(vk::CommandBufferBeginInfo());
    // Waiting for the fence of the last submission made its results available, not yet visible.
    barrier(made.front(), Stage::eAllCommands, Access::eMemoryWrite, Stage::eAllCommands,
            Access::eMemoryRead | Access::eMemoryWrite);
    return std::move(made.front());
  }

  /// Waits until it is done. Where something fails nothing is left that the device still works on.
  void submit(const vk::raii::CommandBuffer& recorded) const {
    try {
      device_.resetFences(*fence_);
      queue_.submit(vk::SubmitInfo({}, {}, *recorded), *fence_);
      while (device_.waitForFences(*fence_, VK_TRUE, std::numeric_limits<std::uint64_t>::max()) ==
             vk::Result::eTimeout) {
      }
    } catch (...) {
      // Without an error: a device that is lost has no work left.
      device_.getDispatcher()->vkDeviceWaitIdle(static_cast<VkDevice>(*device_));
      throw;
    }
  }

  void flush() {
    if (recording_) {
      const vk::raii::CommandBuffer commands = std::move(*recording_);
      recording_.reset();
      const bool is_timed = *times_ != vk::QueryPool();
      if (is_timed) {
        commands.writeTimestamp(Stage::eBottomOfPipe, *times_, 1);
      }
      commands.end();
      submit(commands);
      if (is_timed) {
        constexpr std::size_t bytes = sizeof(std::uint64_t);
        const auto flags = vk::QueryResultFlagBits::e64 | vk::QueryResultFlagBits::eWait;
        const auto ticks = times_.getResult<std::array<std::uint64_t, 2>>(0, 2, bytes, flags).second;
        const std::uint64_t passed = (ticks[1] - ticks[0]) << (64 - clock_bits_) >> (64 - clock_bits_);
        busy_.add(tick_ * static_cast<double>(passed));
      }
    }
  }

  void append(const vk::raii::CommandBuffer& to, std::span<const Commands::value_type> commands) {
    for (const auto& command : commands) {
      std::visit(
          [&](const auto& one) {
            if (!one.beside) {
              const vk::PipelineStageFlags stages = Stage::eComputeShader | Stage::eTransfer;
              barrier(to, stages, Access::eShaderWrite | Access::eTransferWrite, stages,
                      Access::eShaderRead | Access::eShaderWrite | Access::eTransferRead |
                          Access::eTransferWrite);
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
    to.dispatch(static_cast<std::uint32_t>(dispatch.groups.width),
                static_cast<std::uint32_t>(dispatch.groups.height),
                static_cast<std::uint32_t>(dispatch.groups.depth));
  }
  static void append(const vk::raii::CommandBuffer& to, const Fill& fill) {
    to.fillBuffer(*of(*fill.array).buffer.handle, fill.first, fill.bytes, 0);
  }

  const vk::raii::DescriptorSet& set_of(const std::array<const Array*, binding::count>& arrays) {
    auto found = sets_.find(arrays);
    if (found == sets_.end()) {
      auto made = device_.allocateDescriptorSets({*set_pool_, *set_layout_});
      found = sets_.emplace(arrays, std::move(made.front())).first;
      for (std::uint32_t number = 0; number < binding::count; ++number) {
        if (arrays[number] != nullptr) {
          const VulkanArray& array = of(*arrays[number]);
          const vk::BufferView view = *array.view;
          const vk::DescriptorBufferInfo whole(*array.buffer.handle, 0, VK_WHOLE_SIZE);
          vk::WriteDescriptorSet write(*found->second, number, 0, 1, type_of(number));
          write.setPTexelBufferView(&view).setPBufferInfo(&whole);
          device_.updateDescriptorSets(write, {});
        }
      }
    }
    return found->second;
  }

  std::shared_ptr<const Installation> installation_;
  Device description_;
  vk::PhysicalDeviceMemoryProperties memory_;
  DeviceLimits limits_;
  vk::raii::Device device_;
  vk::raii::Queue queue_;
  vk::raii::CommandPool command_pool_;
  vk::raii::Fence fence_;
  Buffer staging_;
  std::byte* staged_; ///< staging_, mapped for as long as it lives
  vk::raii::DescriptorSetLayout set_layout_;
  vk::raii::PipelineLayout layout_;
  vk::raii::DescriptorPool set_pool_;
  std::map<std::array<const Array*, binding::count>, vk::raii::DescriptorSet> sets_;
  std::uint32_t clock_bits_;            ///< 0: the device has no clock
  double tick_;                         ///< seconds
  vk::raii::QueryPool times_ = nullptr; ///< where a recording begins and ends, once that is asked for
  BusySeconds busy_;
  std::optional<vk::raii::CommandBuffer> recording_;
};

VulkanArray::VulkanArray(VulkanDevice& device, std::size_t count, Kind kind)
    : Array(device, count, kind), device_(device) {
  const vk::BufferUsageFlags usage = kind == Kind::words
                                         ? vk::BufferUsageFlags(Usage::eStorageBuffer)
                                         : Usage::eUniformTexelBuffer | Usage::eStorageTexelBuffer;
  buffer = device.make_buffer(bytes(), usage | Usage::eTransferSrc | Usage::eTransferDst, Placement::device);
  if (kind != Kind::words) {
    view = device.device().createBufferView({{}, *buffer.handle, format_of(kind), 0, bytes()});
  }
}

VulkanArray::~VulkanArray() {
  device_.forget(*this);
}

class VulkanApi final : public ComputeApi {
public:
  [[nodiscard]] std::vector<Device> devices() const override {
    return translate_errors([&] {
      std::vector<Device> all;
      for (const FoundDevice& device : installation()->compute_devices()) {
        all.push_back(describe(device.physical));
      }
      return all;
    });
  }

  [[nodiscard]] std::unique_ptr<ComputeDevice> open(std::size_t index) const override {
    return translate_errors([&] {
      const std::vector<FoundDevice> devices = installation()->compute_devices();
      if (index >= devices.size()) {
        throw DeviceError(fmt::format("Vulkan device {} has gone, {} are left", index, devices.size()));
      }
      return std::make_unique<VulkanDevice>(installation(), devices[index]);
    });
  }

private:
  /// One for all devices, and it stays: NVIDIA's driver cannot be loaded any more after some 40 times.
  [[nodiscard]] const std::shared_ptr<const Installation>& installation() const {
    if (!installation_) {
      installation_ = std::make_shared<const Installation>();
    }
    return installation_;
  }

  mutable std::shared_ptr<const Installation> installation_;
};

} // namespace

} // namespace hdmbench::vulkan

namespace hdmbench {

std::unique_ptr<Backend> make_vulkan_compute() {
  return make_device_backend({.name = vulkan::backend_name,
                              .description = "GLSL 4.50 compute shader (SPIR-V), Vulkan 1.1, texel buffers",
                              .language = "GLSL 4.50, compute, SPIR-V"},
                             std::make_unique<vulkan::VulkanApi>());
}

} // namespace hdmbench
