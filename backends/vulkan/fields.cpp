#include "backends/vulkan/fields.hpp"

#include <algorithm>
#include <cstring>

namespace hdmbench::vulkan {

namespace {

using Usage = vk::BufferUsageFlagBits;

constexpr vk::Format format_of_pairs = vk::Format::eR32G32Sfloat;
constexpr vk::Format format_of_fours = vk::Format::eR32G32B32A32Sfloat;
constexpr vk::DeviceSize bytes_of_pair = 2 * sizeof(float);
constexpr vk::DeviceSize bytes_of_four = 4 * sizeof(float);
constexpr vk::DeviceSize staging_bytes = vk::DeviceSize{16} << 20;

TexelBuffer make(const Queue& queue, vk::Format format, std::size_t count, vk::BufferUsageFlags usage) {
  const vk::DeviceSize bytes = count * (format == format_of_pairs ? bytes_of_pair : bytes_of_four);
  TexelBuffer made;
  made.buffer =
      queue.make_buffer(bytes, usage | Usage::eUniformTexelBuffer | Usage::eTransferDst, Placement::device);
  made.view = queue.device().createBufferView({{}, *made.buffer.handle, format, 0, bytes});
  return made;
}

vk::BufferUsageFlags usage_of(bool sampled) {
  return sampled ? Usage::eStorageTexelBuffer : vk::BufferUsageFlags{};
}

} // namespace

void require_texel_buffers(const vk::raii::PhysicalDevice& physical) {
  using Feature = vk::FormatFeatureFlagBits;
  const auto require = [&](vk::Format format, vk::FormatFeatureFlags needed) {
    const vk::FormatFeatureFlags found = physical.getFormatProperties(format).bufferFeatures;
    if ((found & needed) != needed) {
      throw DeviceError(fmt::format("{}: buffers of {} can only be {}, the sweep needs {}",
                                    describe(physical).name, vk::to_string(format), vk::to_string(found),
                                    vk::to_string(needed)));
    }
  };
  require(format_of_pairs, Feature::eUniformTexelBuffer | Feature::eStorageTexelBuffer);
  require(format_of_fours, Feature::eUniformTexelBuffer | Feature::eStorageTexelBuffer);
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

LevelFields::LevelFields(const Queue& queue, std::size_t capacity_, bool curvature_, bool sampled)
    : capacity(capacity_), curvature(curvature_),
      material(make(queue, format_of_pairs, capacity, usage_of(sampled))),
      observation(make(queue, format_of_fours, capacity, usage_of(sampled))),
      inverse_curvature(make(queue, format_of_pairs, curvature ? capacity : 1, {})) {}

Displacements::Displacements(const Queue& queue, std::size_t capacity_) : capacity(capacity_) {
  for (TexelBuffer& buffer : buffers) {
    buffer = make_pairs(queue, capacity);
  }
}

TexelBuffer make_entries(const Queue& queue, std::size_t count) {
  return make(queue, format_of_fours, count, {});
}

TexelBuffer make_pairs(const Queue& queue, std::size_t count) {
  return make(queue, format_of_pairs, count, Usage::eStorageTexelBuffer | Usage::eTransferSrc);
}

vk::DeviceSize bytes_per_site(bool curvature) {
  return 2 * bytes_of_pair + bytes_per_site_of_fields() + (curvature ? bytes_of_pair : 0);
}

vk::DeviceSize bytes_per_site_of_fields() {
  return bytes_of_four + bytes_of_pair;
}

vk::DeviceSize most_bytes_per_site() {
  return bytes_of_four;
}

Staging::Staging(const Queue& queue)
    : queue_(&queue),
      staging_(queue.make_buffer(staging_bytes, Usage::eTransferSrc | Usage::eTransferDst, Placement::host)),
      staged_(staging_.memory.mapMemory(0, VK_WHOLE_SIZE)) {}

void Staging::upload(std::span<const float* const> planes, std::size_t count, const TexelBuffer& to) const {
  const std::size_t components = planes.size();
  const vk::DeviceSize texel = components * sizeof(float);
  const std::size_t piece = staging_bytes / texel;
  auto* const staged = static_cast<float*>(staged_);
  for (std::size_t first = 0; first < count; first += piece) {
    const std::size_t here = std::min(piece, count - first);
    for (std::size_t component = 0; component < components; ++component) {
      const float* from = planes[component] + first;
      for (std::size_t i = 0; i < here; ++i) {
        staged[components * i + component] = from[i];
      }
    }
    queue_->submit([&](const vk::raii::CommandBuffer& commands) {
      commands.copyBuffer(*staging_.handle, *to.buffer.handle,
                          vk::BufferCopy(0, first * texel, here * texel));
    });
  }
}

void Staging::download(const TexelBuffer& from, VectorField& to) const {
  constexpr std::size_t piece = staging_bytes / bytes_of_pair;
  const std::size_t sites = to.extent.sites();
  for (std::size_t first = 0; first < sites; first += piece) {
    const std::size_t count = std::min(piece, sites - first);
    queue_->submit([&](const vk::raii::CommandBuffer& commands) {
      copy_here(commands, from.buffer, first * bytes_of_pair, count * bytes_of_pair);
    });
    const auto* pairs = static_cast<const float*>(staged_);
    for (std::size_t i = 0; i < count; ++i) {
      to.x[first + i] = pairs[2 * i];
      to.y[first + i] = pairs[2 * i + 1];
    }
  }
}

std::uint32_t Staging::download_number(const Buffer& from) const {
  queue_->submit(
      [&](const vk::raii::CommandBuffer& commands) { copy_here(commands, from, 0, sizeof(std::uint32_t)); });
  std::uint32_t number = 0;
  std::memcpy(&number, staged_, sizeof number);
  return number;
}

void Staging::copy_here(const vk::raii::CommandBuffer& commands, const Buffer& from, vk::DeviceSize offset,
                        vk::DeviceSize bytes) const {
  commands.copyBuffer(*from.handle, *staging_.handle, vk::BufferCopy(offset, 0, bytes));
  barrier(commands, vk::PipelineStageFlagBits::eTransfer, vk::AccessFlagBits::eTransferWrite,
          vk::PipelineStageFlagBits::eHost, vk::AccessFlagBits::eHostRead);
}

} // namespace hdmbench::vulkan
