#pragma once

#include "backends/opencl/device.hpp"

#include <array>
#include <cstddef>
#include <initializer_list>
#include <span>

namespace hdmbench::opencl {

/// How arrays over the sites of an extent lie in a buffer (kernels/shaders/sweep.cl): planes of one float a
/// site, row by row, with room around for what a row reads beyond the border.
struct Layout {
  Layout() = default;
  explicit Layout(Extent extent)
      : origin((static_cast<std::size_t>(extent.width) + 16) / 16 * 16),
        plane((extent.sites() + 2 * origin + 15) / 16 * 16) {}

  [[nodiscard]] std::size_t bytes(std::size_t planes) const { return planes * plane * sizeof(float); }
  /// Byte of the first site of plane `number`.
  [[nodiscard]] std::size_t offset(std::size_t number) const {
    return (number * plane + origin) * sizeof(float);
  }

  std::size_t origin = 0; ///< floats, of the first site in a plane
  std::size_t plane = 0;  ///< floats
};

/// Writes values of the first sites, one span for each plane, into a buffer that has room for them. Throws
/// DeviceError.
void write_planes(const Queue& queue, const Buffer& buffer, const Layout& layout,
                  std::initializer_list<std::span<const float>> planes);

/// What does not change during the sweeps of a level.
struct Fields {
  Buffer material;          ///< modulus, 1 / modulus
  Buffer observation;       ///< target x, y, confidence x, y
  Buffer inverse_curvature; ///< x, y; one float where no rule needs it
};

/// Makes room for levels of such a layout. Throws DeviceError.
void make_room(const Queue& queue, Fields& fields, const Layout& layout, bool curvature);

/// The level's own, in room that was made. Throws DeviceError.
void upload(const Queue& queue, const Fields& fields, const Layout& layout, const Level& level);

/// Throws TooLarge where the device has no room for a level of this layout, of which `sampled` sites or none
/// are sampled.
void require_fits(const FoundDevice& device, const Level& level, std::size_t sampled);

} // namespace hdmbench::opencl
