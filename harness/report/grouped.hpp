#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace hdmbench {

/// 1234567 as 1,234,567; `value` >= 0.
[[nodiscard]] inline std::string grouped(std::int64_t value) {
  std::string digits = std::to_string(value);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<std::size_t>(at), 1, ',');
  }
  return digits;
}

} // namespace hdmbench
