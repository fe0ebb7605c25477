#pragma once

#include "backends/vulkan/compute_device.hpp"
#include "kernels/data/field.hpp"

#include <array>
#include <cstddef>
#include <span>

/// What lies on a Vulkan device for the sites of a level, and the way there and back.
namespace hdmbench::vulkan {

/// Throws DeviceError where the device lacks a format or a feature that Vulkan leaves optional.
void require_texel_buffers(const vk::raii::PhysicalDevice& physical);
[[nodiscard]] vk::PhysicalDeviceFeatures needed_features();

/// Floats in groups of 2 or 4.
struct TexelBuffer {
  Buffer buffer;
  vk::raii::BufferView view = nullptr;
};

/// What a level has and its sweeps do not change, of as many sites as `capacity`.
struct LevelFields {
  /// Without `curvature` or `sampled`: no room for 1 / curvature, not written by shaders.
  LevelFields(const Queue& queue, std::size_t capacity, bool curvature, bool sampled);

  std::size_t capacity;
  bool curvature;
  TexelBuffer material;          ///< modulus, 1 / modulus
  TexelBuffer observation;       ///< target x, y, confidence x, y
  TexelBuffer inverse_curvature; ///< x, y; of one site without `curvature`
};

/// Displacements of as many sites as `capacity`, read and written in turn.
struct Displacements {
  Displacements(const Queue& queue, std::size_t capacity);

  std::size_t capacity;
  std::array<TexelBuffer, 2> buffers;
};

/// Four floats per entry, never changed by shaders.
[[nodiscard]] TexelBuffer make_entries(const Queue& queue, std::size_t count);

/// Two floats per entry, which shaders read and write, as the CPU does.
[[nodiscard]] TexelBuffer make_pairs(const Queue& queue, std::size_t count);

/// Bytes that a site takes in LevelFields and Displacements, and in sampled LevelFields alone.
[[nodiscard]] vk::DeviceSize bytes_per_site(bool curvature);
[[nodiscard]] vk::DeviceSize bytes_per_site_of_fields();
/// The most that a site takes in one buffer.
[[nodiscard]] vk::DeviceSize most_bytes_per_site();

/// Fields pass through it in pieces, interleaved on the device and planar on the host. What is
/// given as queue must outlive it.
class Staging {
public:
  explicit Staging(const Queue& queue);

  /// `count` values of one plane per component.
  void upload(std::span<const float* const> planes, std::size_t count, const TexelBuffer& to) const;
  void download(const TexelBuffer& from, VectorField& to) const;
  [[nodiscard]] std::uint32_t download_number(const Buffer& from) const;

private:
  /// Once the submission is done the CPU finds the bytes at staged_.
  void copy_here(const vk::raii::CommandBuffer& commands, const Buffer& from, vk::DeviceSize offset,
                 vk::DeviceSize bytes) const;

  const Queue* queue_;
  Buffer staging_;
  void* staged_; // staging_, mapped for as long as it lives
};

} // namespace hdmbench::vulkan
