#pragma once

#include <bit>
#include <cstdint>

namespace hdmbench {

/// The bits of a number >= 0: such numbers have the order of their bits. The greatest of integers is found
/// many at a time; that of floats is not, as one of them may be no number.
[[nodiscard]] constexpr std::int32_t ordered_bits(float number) {
  return std::bit_cast<std::int32_t>(number);
}

} // namespace hdmbench
