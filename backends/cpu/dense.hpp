#pragma once

#include "backends/cpu/sweeper.hpp"

#include <array>
#include <cstdint>

namespace hdmbench::openmp {

/// Sweeps that pass through a band together: a large image is read from memory once for all of them.
inline constexpr int most_fused = 8;

/// Two buffers of one field, and which of them is the newest. Coloured updates use one only.
struct Fields {
  std::array<Field, 2> buffers;
  std::size_t newest = 0;
};

/// All sites `sweeps` times, from sweep number `first` of the level on; the newest buffer moves on. With a
/// projection the newest buffer is first filled by it. Returns what the last sweep changed.
[[nodiscard]] std::int64_t sweep_densely(const Sweeper& sweeper, Fields& fields, int first, int sweeps,
                                         int threads, const FieldProjection* projection = nullptr);

} // namespace hdmbench::openmp
