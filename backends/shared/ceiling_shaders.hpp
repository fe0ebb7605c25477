#pragma once

#include "backends/shared/ceilings.hpp"

#include <span>

namespace hdmbench::ceiling_shaders {

/// What the shaders of all interfaces read: texels of a value that differs from its neighbours', twice, and
/// the factor -1 and the term 3 of the multiply-adds, which no compiler can know.
inline constexpr std::size_t texel_bytes = 4 * sizeof(float);
[[nodiscard]] std::vector<float> source(std::size_t texels);

/// In ceiling_multiply_add.comp and its twin for fragments.
inline constexpr int chains = 12; ///< of multiply-adds per texel
inline constexpr int rounds = 8 * 64 + 1;
inline constexpr std::size_t texels = std::size_t{1} << 18; ///< that are computed
[[nodiscard]] constexpr double operations() {
  return 2.0 * chains * rounds * static_cast<double>(texels);
}

/// Throw DeviceError unless `found` is what the shaders make of `given`, texel by texel.
void require_copied(std::span<const float> given, std::span<const float> found);
void require_computed(std::span<const float> given, std::span<const float> found);

} // namespace hdmbench::ceiling_shaders
