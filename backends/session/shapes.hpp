#pragma once

#include "backends/device/device.hpp"
#include "kernels/data/pyramid.hpp"

#include <cstddef>
#include <cstdint>

namespace hdmbench {

/// Tiles of sites, which a work group sweeps: an invocation goes down `columns` columns side by
/// side, so that each row is fetched once (kernels/shaders/tile.glsl), or along them in OpenCL C, where a
/// single one on a CPU goes along the whole row (kernels/shaders/sweep.cl).
struct SweepShape {
  Extent tile{};      ///< sites; divides 128 x 64
  int columns = 1;    ///< divides the width; 1 or 2 in shaders
  int simd_width = 1; ///< sites side by side of a loop along the row: a hint to the compiler
  /// Tiles for a work group where tiles are left out: one that has nothing to do costs more than a flag read.
  std::uint32_t tiles_a_group = 1;

  [[nodiscard]] constexpr int invocations() const { return tile.width / columns; }
};

/// How a device computes. The bits are the same by every shape.
struct Shapes {
  SweepShape sweep;
  /// The first levels of a pyramid are computed by one work group of so many invocations
  /// (kernels/shaders/coarse_levels.comp): a dispatch takes longer to start than such a level takes to sweep.
  /// 0: by a dispatch for each sweep.
  int coarse_group = 0;
};

/// Those of the table in shapes.cpp for such a device.
[[nodiscard]] Shapes shapes_for(const ComputeDevice& device);

/// How many of the first levels one dispatch of `group` invocations may compute: 0 where `group` is 0, or
/// where another rule or order of sites needs to know which sweep it is, or for a volume. Never the last
/// level, whose last two fields changed() compares, and not so much that a driver would end it early.
[[nodiscard]] std::size_t coarse_level_count(const Pyramid& pyramid, int group);

} // namespace hdmbench
