#include "harness/tools/field_lines.hpp"

#include "harness/scene/files.hpp"
#include "harness/scene/names.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

constexpr std::string_view white_space = " \t\r\v\f";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(white_space);
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(white_space) - first + 1);
}

template <typename Number>
std::optional<Number> parse(std::string_view text) {
  return number_of<Number>(text.substr(text.starts_with('+') ? 1 : 0));
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
  const bool by_semicolon = line.find(';') != std::string_view::npos;
  const bool by_comma = line.find(',') != std::string_view::npos;
  const std::string_view separators = by_semicolon ? ";" : by_comma ? "," : white_space;
  while (true) {
    const auto end = line.find_first_of(separators);
    fields_.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) {
      return;
    }
    line = separators == white_space ? trimmed(line.substr(end)) : line.substr(end + 1);
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

template <typename Number>
Number FieldLines::value(std::size_t index, std::string_view what, std::string_view kind) const {
  if (index >= fields_.size()) {
    fail(fmt::format("the {} is missing", what));
  }
  const auto value = parse<Number>(fields_[index]);
  if (!value) {
    fail(fmt::format("the {} is \"{}\", which is not a {}", what, fields_[index], kind));
  }
  return *value;
}

double FieldLines::number(std::size_t index, std::string_view what) const {
  const double number = value<double>(index, what, "number");
  if (!std::isfinite(number)) {
    fail(fmt::format("the {} is {}, it must be finite", what, fields_[index]));
  }
  return number;
}

std::int64_t FieldLines::integer(std::size_t index, std::string_view what) const {
  return value<std::int64_t>(index, what, "whole number");
}

void FieldLines::fail(std::string_view message) const {
  throw InputError(fmt::format("{}:{}: {}", file_, line_, message));
}

void FieldLines::fail_file(std::string_view message) const {
  throw InputError(fmt::format("{}: {}", file_, message));
}

} // namespace hdmbench
