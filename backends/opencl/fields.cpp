#include "backends/opencl/fields.hpp"

#include <fmt/format.h>

#include <limits>

namespace hdmbench::opencl {

void write_planes(const Queue& queue, const Buffer& buffer, const Layout& layout,
                  std::initializer_list<std::span<const float>> planes) {
  std::size_t number = 0;
  for (const std::span<const float> plane : planes) {
    queue.write(buffer, layout.offset(number++), plane);
  }
}

void make_room(const Queue& queue, Fields& fields, const Layout& layout, bool curvature) {
  queue.make_room(fields.material, layout.bytes(2));
  queue.make_room(fields.observation, layout.bytes(4));
  queue.make_room(fields.inverse_curvature, curvature ? layout.bytes(2) : sizeof(float));
}

void upload(const Queue& queue, const Fields& fields, const Layout& layout, const Level& level) {
  write_planes(queue, fields.material, layout, {level.modulus.values, level.inverse_modulus.values});
  write_planes(queue, fields.observation, layout,
               {level.target.x, level.target.y, level.confidence.x, level.confidence.y});
  if (needs_inverse_curvature(level.rule)) {
    write_planes(queue, fields.inverse_curvature, layout,
                 {level.inverse_curvature.x, level.inverse_curvature.y});
  }
}

void require_fits(const FoundDevice& device, const Level& level, std::size_t sampled) {
  const Layout layout(level.extent);
  const std::size_t largest = layout.bytes(4);
  const std::size_t planes =
      2 * 2 + 2 + 4 + (needs_inverse_curvature(level.rule) ? 2 : 0) + level.inputs.size();
  const std::size_t all = layout.bytes(planes) + sampled * (2 + 4 + level.inputs.size()) * sizeof(float);
  if (largest > device.largest_buffer || all > device.memory ||
      layout.plane > std::numeric_limits<std::int32_t>::max()) {
    throw TooLarge(fmt::format("{}: {} x {} sites need {} bytes, {} of them in one buffer; the device has {} "
                               "and takes {} in one",
                               device.description.name, level.extent.width, level.extent.height, all, largest,
                               device.memory, device.largest_buffer));
  }
}

} // namespace hdmbench::opencl
