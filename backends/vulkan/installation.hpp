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

/// A logical device with one queue. Throws DeviceError where it lacks a format or a feature that Vulkan
/// leaves optional.
[[nodiscard]] vk::raii::Device make_device(const FoundDevice& chosen);

} // namespace hdmbench::vulkan
