#include "harness/scene/toml_reader.hpp"

#include "harness/scene/nearest_name.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace hdmbench {

namespace {

const toml::table empty_table;

using Names = std::vector<std::string_view>;

/// The keys of each table, as harness/scene/scenes/README.md explains them; "" are those above all tables.
const std::map<std::string_view, Names> known_keys{
    {"",
     {"title", "size", "penalty", "prior_weight", "steps", "poisson", "energy", "robust", "spacing", "exact",
      "schedule", "image", "brain", "random", "shape", "tissue", "condition"}},
    {"schedule",
     {"method", "iterations", "stop", "epsilon", "start_level", "alignment", "update", "relaxation",
      "temperatures", "seed"}},
    {"image",
     {"labels", "modulus", "slice", "picture", "picture_range", "target", "confidence", "deviation",
      "start"}},
    {"brain", {"file", "slice", "orientation", "classes", "margin"}},
    {"random", {"seed", "modulus", "moduli", "displacement", "grid", "observed", "confidences"}},
    {"shape", {"kind", "label", "centre", "size"}},
    {"tissue", {"label", "name", "modulus", "gray"}},
    {"condition", {"where", "dx", "dy", "outward", "closing", "confidence", "deviation"}},
};

constexpr std::string_view of_hdm = "it belongs to energy = \"hdm\", which is the usual one";
constexpr std::string_view of_elastic = "it belongs to energy = \"elastic\"";

/// Where a key has an effect that has one only somewhere.
const std::map<std::string_view, std::string_view> only{
    {"penalty", of_hdm},
    {"prior_weight", of_hdm},
    {"steps", of_hdm},
    {"stop", of_hdm},
    {"start_level", of_hdm},
    {"alignment", of_hdm},
    {"start", of_hdm},
    {"robust", of_elastic},
    {"deviation", of_elastic},
    {"epsilon", "it belongs to stop = \"energy\""},
    {"closing", "it belongs to where = \"outside\""},
    {"picture_range", "it belongs to a picture"},
    {"tissue", "moduli of tissues belong to labels"},
    {"gray", "it belongs to [[shape]], or to labels without a picture"},
    {"centre", "everything has no centre"},
    {"size", "everything has no size"},
};

/// `where` is the name of a table in errors: "[schedule]", "[[tissue]]", "".
const Names& keys_of(std::string_view where) {
  const std::size_t first = std::min(where.find_first_not_of('['), where.size());
  return known_keys.at(where.substr(first, where.find(']') - first));
}

} // namespace

TomlReader::TomlReader(const toml::table& table, std::string file, std::string where)
    : table_(table), file_(std::move(file)), where_(std::move(where)) {
  const Names& names = keys_of(where_);
  for (const auto& [key, node] : table_) {
    if (std::ranges::find(names, key.str()) == names.end()) {
      const std::string all = fmt::format("those understood are {}", fmt::join(names, ", "));
      fail(key.str(),
           fmt::format("is not a key of scene files here; {}", did_you_mean(key.str(), names, all)));
    }
  }
}

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

double TomlReader::number(std::string_view key) {
  return as_number(key, require(key));
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
  if (const auto found = std::ranges::find(choices, value); found != choices.end()) {
    return static_cast<std::size_t>(found - choices.begin());
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

void TomlReader::refuse_unless(bool has_effect, std::string_view key) const {
  if (!has_effect && table_.contains(key)) {
    const auto found = only.find(key);
    fail(key, fmt::format("has no effect in this scene{}{}; leave it out", found == only.end() ? "" : ": ",
                          found == only.end() ? "" : found->second));
  }
}

void TomlReader::finish() const {
  for (const auto& [key, node] : table_) {
    refuse_unless(asked_for_.contains(key.str()), key.str());
  }
}

void TomlReader::fail(std::string_view key, std::string_view message) const {
  const toml::node* node = table_.get(key);
  const auto line = (node != nullptr ? *node : static_cast<const toml::node&>(table_)).source().begin.line;
  throw InputError(
      fmt::format("{}:{}: {}{}{} {}", file_, line, where_, where_.empty() ? "" : " ", key, message));
}

} // namespace hdmbench
