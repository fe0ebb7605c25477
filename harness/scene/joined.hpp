#pragma once

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

} // namespace hdmbench
