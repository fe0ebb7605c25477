#pragma once

#include "backends/backend.hpp"

#include <fmt/format.h>
#include <vulkan/vulkan_raii.hpp>

#include <concepts>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

/// What any computation on a Vulkan device needs; knows nothing about what is computed.
namespace hdmbench::vulkan {

/// call(), with what Vulkan throws (the name of the Vulkan function and its result) turned into DeviceError.
template <typename Call>
decltype(auto) translate_errors(Call&& call) {
  try {
    return std::forward<Call>(call)();
  } catch (const vk::Error& error) {
    throw DeviceError(fmt::format("Vulkan: {}", error.what()));
  }
}

/// The loader (opened at run time) and an instance of Vulkan 1.1. The constructor throws DeviceError with the
/// reason where there is none; so does compute_devices() where no device has Vulkan 1.1 and a compute queue.
class Installation {
public:
  Installation();

  struct ComputeDevice {
    vk::raii::PhysicalDevice physical;
    std::uint32_t queue_family;
  };
  /// In the loader's order.
  [[nodiscard]] std::vector<ComputeDevice> compute_devices() const;

private:
  vk::raii::Context context_;
  vk::raii::Instance instance_;
};

[[nodiscard]] Device describe(const vk::raii::PhysicalDevice& physical);

struct Buffer {
  vk::raii::DeviceMemory memory = nullptr; // first, so that it outlives the buffer bound to it
  vk::raii::Buffer handle = nullptr;
};

/// Where a buffer's memory lies.
enum class Placement {
  device, ///< the device's own memory, which the CPU may not be able to see
  host,   ///< visible to the CPU, coherent, cached by the CPU where the device has such memory
};

/// A logical device with one compute queue. Work is submitted, waited for, and only then the call returns.
class Queue {
public:
  /// `chosen` is one of installation's; `features` must be supported.
  Queue(Installation installation, const Installation::ComputeDevice& chosen,
        const vk::PhysicalDeviceFeatures& features);

  [[nodiscard]] const vk::raii::PhysicalDevice& physical() const { return physical_; }
  [[nodiscard]] const vk::raii::Device& device() const { return device_; }

  [[nodiscard]] Buffer make_buffer(vk::DeviceSize bytes, vk::BufferUsageFlags usage,
                                   Placement placement) const;
  /// Bytes of the heap that buffers placed so come from.
  [[nodiscard]] vk::DeviceSize heap_bytes(Placement placement) const;

  /// record(commands) fills a command buffer; all that was submitted before is done and visible to it. Where
  /// something fails nothing is left that the device still works on, and the next submission is like the
  /// first.
  template <std::invocable<const vk::raii::CommandBuffer&> Record>
  void submit(Record&& record) const {
    try {
      begin(commands_.front(), vk::CommandBufferUsageFlagBits::eOneTimeSubmit);
      record(commands_.front());
      commands_.front().end();
      run(commands_.front());
    } catch (...) {
      recover();
      throw;
    }
  }

  /// A command buffer that is being recorded, for submit() as often as wanted once it is ended. What was
  /// submitted before is done and visible to it.
  [[nodiscard]] vk::raii::CommandBuffer begin_recording() const;
  /// Like the other one.
  void submit(const vk::raii::CommandBuffer& recorded) const;

private:
  /// Among the types whose bit is set in `allowed`.
  [[nodiscard]] std::uint32_t memory_type(std::uint32_t allowed, Placement placement) const;
  void begin(const vk::raii::CommandBuffer& commands, vk::CommandBufferUsageFlags usage) const;
  void run(const vk::raii::CommandBuffer& commands) const;
  void recover() const noexcept;

  Installation installation_;
  vk::raii::PhysicalDevice physical_;
  vk::PhysicalDeviceMemoryProperties memory_;
  vk::raii::Device device_;
  vk::raii::Queue queue_;
  vk::raii::CommandPool pool_;
  std::vector<vk::raii::CommandBuffer> commands_; // exactly one
  vk::raii::Fence fence_;
};

/// What the first dispatches or copies wrote becomes visible to those recorded after this.
void barrier(const vk::raii::CommandBuffer& commands, vk::PipelineStageFlags before, vk::AccessFlags written,
             vk::PipelineStageFlags after, vk::AccessFlags used);

/// A compute pipeline of a SPIR-V module's main(); `constants` are those of constant_id 0, 1, ... as far as
/// it has them.
[[nodiscard]] vk::raii::Pipeline make_pipeline(const vk::raii::Device& device,
                                               const vk::raii::PipelineLayout& layout,
                                               std::span<const std::uint32_t> spirv,
                                               std::span<const std::int32_t> constants);

} // namespace hdmbench::vulkan
