#include "harness/scene/toml_reader.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

namespace hdmbench {

namespace {

const toml::table empty_table;

} // namespace

const toml::node* TomlReader::find(std::string_view key) {
  asked_for_.emplace(key);
  return table_.get(key);
}

const toml::node& TomlReader::require(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) {
    fail(key, "is missing");
  }
  return *node;
}

double TomlReader::as_number(std::string_view key, const toml::node& node) const {
  const auto value = node.value<double>();
  if (!value || !(node.is_floating_point() || node.is_integer())) {
    fail(key, "must be a number");
  }
  if (!std::isfinite(*value)) {
    fail(key, fmt::format("is {}, it must be finite", *value));
  }
  return *value;
}

std::string TomlReader::text(std::string_view key) {
  const toml::node& node = require(key);
  if (!node.is_string()) {
    fail(key, "must be a text in quotes");
  }
  return *node.value<std::string>();
}

std::string TomlReader::text(std::string_view key, std::string_view fallback) {
  return has(key) ? text(key) : std::string(fallback);
}

double TomlReader::number(std::string_view key) {
  return as_number(key, require(key));
}

double TomlReader::number(std::string_view key, double fallback) {
  return has(key) ? number(key) : fallback;
}

std::optional<double> TomlReader::optional_number(std::string_view key) {
  return has(key) ? std::optional(number(key)) : std::nullopt;
}

bool TomlReader::boolean(std::string_view key, bool fallback) {
  if (!has(key)) {
    return fallback;
  }
  const auto value = require(key).value_exact<bool>();
  if (!value) {
    fail(key, "must be true or false");
  }
  return *value;
}

int TomlReader::integer(std::string_view key) {
  const toml::node& node = require(key);
  if (!node.is_integer()) {
    fail(key, "must be a whole number");
  }
  const auto value = *node.value<std::int64_t>();
  if (value < -1'000'000'000 || value > 1'000'000'000) {
    fail(key, fmt::format("is {}, out of range", value));
  }
  return static_cast<int>(value);
}

int TomlReader::integer(std::string_view key, int fallback) {
  return has(key) ? integer(key) : fallback;
}

std::array<double, 2> TomlReader::pair(std::string_view key) {
  const toml::array* array = require(key).as_array();
  if (array == nullptr || array->size() != 2) {
    fail(key, "must be two numbers, [x, y]");
  }
  return {as_number(key, *array->get(0)), as_number(key, *array->get(1))};
}

std::vector<float> TomlReader::numbers(std::string_view key) {
  const toml::array* array = require(key).as_array();
  if (array == nullptr) {
    fail(key, "must be a list of numbers");
  }
  std::vector<float> values;
  for (const toml::node& node : *array) {
    values.push_back(static_cast<float>(as_number(key, node)));
  }
  return values;
}

std::size_t TomlReader::choice(std::string_view key, std::span<const std::string_view> choices,
                               std::size_t fallback) {
  if (!has(key)) {
    return fallback;
  }
  const std::string value = text(key);
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (choices[i] == value) {
      return i;
    }
  }
  fail(key, fmt::format("is \"{}\", it must be one of {}", value, fmt::join(choices, ", ")));
}

TomlReader TomlReader::table(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) {
    return {empty_table, file_, fmt::format("[{}]", key)};
  }
  if (!node->is_table()) {
    fail(key, "must be a table");
  }
  return {*node->as_table(), file_, fmt::format("[{}]", key)};
}

std::vector<TomlReader> TomlReader::tables(std::string_view key) {
  std::vector<TomlReader> readers;
  const toml::node* node = find(key);
  if (node == nullptr) {
    return readers;
  }
  if (!node->is_array_of_tables()) {
    fail(key, fmt::format("must be written as [[{}]]", key));
  }
  for (const toml::node& element : *node->as_array()) {
    readers.emplace_back(*element.as_table(), file_, fmt::format("[[{}]]", key));
  }
  return readers;
}

void TomlReader::finish() const {
  for (const auto& [key, node] : table_) {
    if (!asked_for_.contains(key.str())) {
      fail(key.str(), fmt::format("is not a key of scene files here; those understood are {}",
                                  fmt::join(asked_for_, ", ")));
    }
  }
}

void TomlReader::fail(std::string_view key, std::string_view message) const {
  const toml::node* node = table_.get(key);
  const auto line = (node != nullptr ? *node : static_cast<const toml::node&>(table_)).source().begin.line;
  throw InputError(
      fmt::format("{}:{}: {}{}{} {}", file_, line, where_, where_.empty() ? "" : " ", key, message));
}

} // namespace hdmbench
