#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace hdmbench {

/// The texts of a range with `separator` between them. (fmt::join trips g++ 12's -Wstringop-overflow.)
template <typename Texts>
[[nodiscard]] std::string joined(const Texts& texts, std::string_view separator) {
  std::string result;
  bool first = true;
  for (const std::string& text : texts) {
    if (!first) {
      result += separator;
    }
    result += text;
    first = false;
  }
  return result;
}

/// "1st", "12th", "61st" of a number > 0.
[[nodiscard]] inline std::string ordinal(int number) {
  constexpr std::array<const char*, 4> endings{"th", "st", "nd", "rd"};
  const int last = number / 10 % 10 == 1 ? 0 : number % 10;
  return std::to_string(number) + endings.at(last < 4 ? static_cast<std::size_t>(last) : 0);
}

} // namespace hdmbench
