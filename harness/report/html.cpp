#include "harness/report/html.hpp"

#include "harness/scene/file_input.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace hdmbench::report {

std::string escape(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (const char letter : text) {
    switch (letter) {
    case '&':
      result += "&amp;";
      break;
    case '<':
      result += "&lt;";
      break;
    case '>':
      result += "&gt;";
      break;
    case '"':
      result += "&quot;";
      break;
    case '\'':
      result += "&#39;";
      break;
    case '\t':
    case '\n':
      result += letter;
      break;
    default:
      if (static_cast<unsigned char>(letter) < 0x20 || letter == 0x7F) {
        result += "\uFFFD";
      } else {
        result += letter;
      }
    }
  }
  return result;
}

std::string seconds_text(double seconds) {
  if (!std::isfinite(seconds) || seconds <= 0.0) {
    return fmt::format("{}", seconds);
  }
  const int magnitude = static_cast<int>(std::floor(std::log10(seconds)));
  return fmt::format("{:.{}f}", seconds, std::clamp(2 - magnitude, 0, 9));
}

std::string speed_up_text(double speed_up) {
  return fmt::format("{:.{}f}×", speed_up, speed_up < 10.0 ? 2 : speed_up < 100.0 ? 1 : 0);
}

std::string count_text(std::int64_t count) {
  std::string digits = fmt::format("{}", count);
  for (std::ptrdiff_t position = std::ssize(digits) - 3; position > (count < 0 ? 1 : 0); position -= 3) {
    digits.insert(static_cast<std::size_t>(position), "\u202F");
  }
  return digits;
}

std::string size_text(std::int64_t width, std::int64_t height) {
  return fmt::format("{}\u00A0×\u00A0{}", width, height);
}

std::string plural(std::int64_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count_text(count), noun, count == 1 ? "" : "s");
}

std::string Anchors::unique(std::string_view text) {
  std::string id;
  for (const char letter : text) {
    const auto byte = static_cast<unsigned char>(letter);
    if (byte < 0x80 && std::isalnum(byte) != 0) {
      id += static_cast<char>(std::tolower(byte));
    } else if (!id.empty() && id.back() != '-') {
      id += '-';
    }
  }
  // A number is set off by a dot, which cannot come from `text`.
  const int number = ++given_[id];
  return number == 1 && !id.empty() ? id : fmt::format("{}.{}", id, number);
}

std::string heading(int level, std::string_view id, std::string_view title) {
  return fmt::format("<h{0} id=\"{1}\">{2}<a class=\"anchor\" href=\"#{1}\" aria-label=\"Link to this "
                     "section\">#</a></h{0}>\n",
                     level, escape(id), escape(title));
}

std::string folded(std::string_view summary, std::string_view content, bool open) {
  return content.empty() ? ""
                         : fmt::format("<details{}><summary>{}</summary>\n{}</details>\n",
                                       open ? " open" : "", summary, content);
}

std::string table_start(std::string_view css_class, const std::vector<std::string_view>& headings) {
  std::string html = fmt::format("<div class=\"scroll\"><table class=\"{}\">\n<thead><tr>", css_class);
  for (const std::string_view text : headings) {
    const bool over_numbers = text.starts_with('>');
    html += fmt::format("<th scope=\"col\"{}>{}</th>", over_numbers ? " class=\"number\"" : "",
                        text.substr(over_numbers ? 1 : 0));
  }
  return html + "</tr></thead>\n<tbody>\n";
}

EmbeddedPng embed_png(const std::filesystem::path& file) {
  const std::string bytes = read_file(file);
  // 8 bytes signature, 8 bytes chunk head ending in "IHDR", then width and height, big endian.
  if (bytes.size() < 24 || bytes.compare(0, 8, "\x89PNG\r\n\x1A\n") != 0 ||
      bytes.compare(12, 4, "IHDR") != 0) {
    throw InputError(fmt::format("{}: is not a PNG picture", file.string()));
  }
  const auto number = [&](std::size_t start) {
    std::uint32_t value = 0;
    for (std::size_t i = start; i < start + 4; ++i) {
      value = value << 8U | static_cast<unsigned char>(bytes[i]);
    }
    return value;
  };
  return {"data:image/png;base64," + base64(bytes), number(16), number(20)};
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
