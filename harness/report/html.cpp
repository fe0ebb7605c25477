#include "harness/report/html.hpp"

#include "harness/scene/files.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace hdmbench::report {

std::string escape(std::string_view text) {
  static constexpr std::string_view special = "&<>\"'";
  static constexpr std::array<const char*, 5> written{"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
  std::string result;
  for (const char letter : printable(text)) {
    const std::size_t at = special.find(letter);
    result += at < special.size() ? written.at(at) : std::string(1, letter);
  }
  return result;
}

std::string base64(std::string_view bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string result;
  result.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t present = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t triple = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      triple = triple << 8U | (j < present ? static_cast<unsigned char>(bytes[i + j]) : 0U);
    }
    for (std::size_t j = 0; j < 4; ++j) {
      result += j <= present ? digits[triple >> (18 - 6 * j) & 63U] : '=';
    }
  }
  return result;
}

} // namespace hdmbench::report
