#pragma once

#include "backends/device/device.hpp"

#include <fmt/format.h>
#include <vulkan/vulkan_raii.hpp>

#include <cstdint>
#include <utility>
#include <vector>

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

struct FoundDevice {
  vk::raii::PhysicalDevice physical;
  std::uint32_t queue_family;
};

/// The loader (opened at run time) and an instance of Vulkan 1.1. Throws DeviceError with the reason where
/// there is none.
struct Installation {
  Installation();

  /// In the loader's order. Throws DeviceError where none has Vulkan 1.1 and a compute queue.
  [[nodiscard]] std::vector<FoundDevice> compute_devices() const;

  vk::raii::Context context;
  vk::raii::Instance instance;
};

[[nodiscard]] Device describe(const vk::raii::PhysicalDevice& physical);

/// Returns the format of a texel of an array of this kind.
[[nodiscard]] vk::Format format_of(Kind kind);

constexpr std::uint32_t bytes_told = 128; ///< of push constants, as every device has them

/// What is bound at a binding (backends/device/device.hpp).
[[nodiscard]] vk::DescriptorType type_of(std::size_t number);
/// Those of all programs.
[[nodiscard]] vk::raii::DescriptorSetLayout make_set_layout(const vk::raii::Device& device);
[[nodiscard]] vk::raii::PipelineLayout make_layout(const vk::raii::Device& device,
                                                   const vk::raii::DescriptorSetLayout& set_layout);

/// A logical device with one queue. Throws DeviceError where it lacks a format or a feature that Vulkan
/// leaves optional.
[[nodiscard]] vk::raii::Device make_device(const FoundDevice& chosen,
                                           const std::vector<const char*>& extensions = {},
                                           const void* features_of_extensions = nullptr);

} // namespace hdmbench::vulkan
