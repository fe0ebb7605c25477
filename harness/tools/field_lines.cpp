#include "harness/tools/field_lines.hpp"

#include "harness/scene/file_input.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace hdmbench {

namespace {

constexpr std::string_view white_space = " \t\r\v\f";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(white_space);
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(white_space) - first + 1);
}

/// The whole of `text` as a number; NaN and infinity count as numbers.
template <typename Number>
std::optional<Number> parse(std::string_view text) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
  }
  Number value{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = result.ec == std::errc{} && result.ptr == text.data() + text.size();
  return whole ? std::optional(value) : std::nullopt;
}

} // namespace

FieldLines::FieldLines(const std::filesystem::path& file) : file_(file.string()), text_(read_file(file)) {
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (text_.starts_with(byte_order_mark)) {
    next_ = byte_order_mark.size();
  }
}

void FieldLines::split(std::string_view line) {
  fields_.clear();
  line = trimmed(line.substr(0, line.find('#')));
  if (line.empty()) {
    return;
  }
  const char separator =
      line.find(';') != std::string_view::npos ? ';' : (line.find(',') != std::string_view::npos ? ',' : ' ');
  while (true) {
    const auto end = separator == ' ' ? line.find_first_of(white_space) : line.find(separator);
    fields_.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) {
      return;
    }
    line = separator == ' ' ? trimmed(line.substr(end)) : line.substr(end + 1);
  }
}

bool FieldLines::next() {
  while (next_ < text_.size()) {
    const auto end = std::min(text_.find('\n', next_), text_.size());
    split(std::string_view(text_).substr(next_, end - next_));
    next_ = end + 1;
    ++line_;
    if (!fields_.empty()) {
      return true;
    }
  }
  fields_.clear();
  return false;
}

bool FieldLines::is_title() const {
  return std::ranges::none_of(fields_, [](std::string_view text) { return parse<double>(text).has_value(); });
}

std::string_view FieldLines::field(std::size_t index, std::string_view what) const {
  if (index >= fields_.size()) {
    fail(fmt::format("the {} is missing", what));
  }
  return fields_[index];
}

double FieldLines::number(std::size_t index, std::string_view what) const {
  const std::string_view text = field(index, what);
  const auto value = parse<double>(text);
  if (!value) {
    fail(fmt::format("the {} is \"{}\", which is not a number", what, text));
  }
  if (!std::isfinite(*value)) {
    fail(fmt::format("the {} is {}, it must be finite", what, text));
  }
  return *value;
}

std::int64_t FieldLines::integer(std::size_t index, std::string_view what) const {
  const std::string_view text = field(index, what);
  const auto value = parse<std::int64_t>(text);
  if (!value) {
    fail(fmt::format("the {} is \"{}\", which is not a whole number", what, text));
  }
  return *value;
}

void FieldLines::fail_at(int line, std::string_view message) const {
  throw InputError(fmt::format("{}:{}: {}", file_, line, message));
}

void FieldLines::fail_file(std::string_view message) const {
  throw InputError(fmt::format("{}: {}", file_, message));
}

} // namespace hdmbench
