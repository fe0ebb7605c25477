#include "harness/scene/toml_reader.hpp"

#include "harness/scene/laws.hpp"
#include "harness/scene/names.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace hdmbench {

namespace {

const toml::table empty_table;

/// A key, as harness/scene/scenes/README.md explains it.
struct Key {
  std::string_view table; ///< that has it; "": above all tables
  std::string_view name;
  std::string_view belongs{}; ///< where it has an effect, if only somewhere
  bool (*is_right)(double) = nullptr;
  std::string_view must_be{}; ///< the end of "it must be ..." where a number is not right
};

constexpr std::string_view of_hdm = "it belongs to energy = \"hdm\", which is the usual one";
constexpr std::string_view of_elastic = "it belongs to energy = \"elastic\"";

constexpr bool is_positive(double value) {
  return value > 0.0;
}
constexpr bool is_not_negative(double value) {
  return value >= 0.0;
}
constexpr bool is_share(double value) {
  return value >= 0.0 && value <= 1.0;
}
bool is_side(double value) {
  return value >= 1.0 && value <= 1e6 && value == std::floor(value);
}

/// Whether a side of a pixel is one that image files may have, too: millimetres.
constexpr bool is_pixel_side(double value) {
  return value >= 1e-6 && value <= 1e6;
}

bool is_modulus(double value) {
  const auto stored = static_cast<float>(value);
  return value > 0.0 && std::isfinite(stored) && std::isfinite(1.0F / stored);
}

/// Whether it is one, or 0: void.
bool is_tissue_modulus(double value) {
  return value == 0.0 || is_modulus(value);
}

const std::array keys_but_laws{
    Key{"", "title"},
    Key{"", "size", {}, is_side, "whole numbers >= 1, [width, height] or [width, height, depth]"},
    Key{"", "penalty", of_hdm},
    Key{"", "prior_weight", of_hdm},
    Key{"", "steps", of_hdm},
    Key{"", "poisson", {}, [](double value) { return value > -1.0 && value <= 0.5; }, "in (-1, 0.5]"},
    Key{"", "integration", "a sheet does not lock"},
    Key{"", "energy"},
    Key{"", "spacing", {}, is_pixel_side, "positive, 1e-6 ... 1e6 (millimetres per pixel)"},
    Key{"", "exact"},
    Key{"", "schedule"},
    Key{"", "image"},
    Key{"", "brain"},
    Key{"", "random"},
    Key{"", "shape"},
    Key{"", "tissue", "moduli of tissues belong to labels"},
    Key{"", "condition"},
    Key{"", "points"},
    Key{"", "load", of_elastic},
    Key{"", "resect", of_elastic},
    Key{"", "law", of_elastic},
    Key{"schedule", "method"},
    Key{"schedule", "iterations"},
    Key{"schedule", "stop", of_hdm},
    Key{"schedule", "epsilon", "it belongs to stop = \"energy\""},
    Key{"schedule", "start_level", of_hdm},
    Key{"schedule", "alignment", of_hdm},
    Key{"schedule", "update"},
    Key{"schedule", "relaxation"},
    Key{"schedule", "temperatures"},
    Key{"schedule", "seed"},
    Key{"image", "labels"},
    Key{"image", "modulus"},
    Key{"image", "slice"},
    Key{"image", "picture"},
    Key{"image", "picture_range", "it belongs to a picture"},
    Key{"image", "target"},
    Key{"image", "target_unit", "it belongs to a target"},
    Key{"image", "confidence"},
    Key{"image", "deviation", of_elastic},
    Key{"image", "precision", of_elastic},
    Key{"image", "force", of_elastic},
    Key{"image", "fibre", of_elastic},
    Key{"image", "normals", of_elastic},
    Key{"image", "start", of_hdm},
    Key{"brain", "file"},
    Key{"brain", "head"},
    Key{"brain", "slice", "a whole head has no slice"},
    Key{"brain", "orientation"},
    // ITK's multi-Otsu tries every combination of thresholds.
    Key{"brain", "classes", {}, [](double value) { return value >= 1.0 && value <= 4.0; }, "1 ... 4"},
    Key{"brain", "sulci", "it belongs to a whole head",
        [](double value) { return value >= 0.0 && value <= 50.0; }, "in [0, 50] (mm)"},
    Key{"brain", "margin", {}, [](double value) { return value >= 0.0 && value < 0.5; }, "in [0, 0.5)"},
    Key{"random", "seed"},
    Key{"random", "modulus", {}, is_positive, "positive (MPa)"},
    Key{"random", "moduli", {}, is_positive, "positive (MPa)"},
    Key{"random", "displacement"},
    Key{"random", "grid", {}, is_not_negative, "at least 0 (pixels)"},
    Key{"random", "observed", {}, is_share, "within 0 ... 1"},
    Key{"random", "confidences", {}, [](double value) { return value > 0.0 && value <= 1.0; }, "in (0, 1]"},
    Key{"shape", "kind"},
    Key{"shape", "label", {}, is_not_negative, "at least 0"},
    Key{"shape", "centre", "everything has no centre"},
    Key{"shape", "size", "everything has no size", is_positive, "positive (fractions of the image)"},
    Key{"tissue", "label"},
    Key{"tissue", "name"},
    Key{"tissue", "source"},
    Key{"tissue",
        "modulus",
        {},
        is_tissue_modulus,
        "positive (MPa), and a 32-bit float must hold it and its inverse; or 0: void"},
    Key{"tissue", "density", "it belongs to a gravity", is_not_negative, "at least 0 (kg/m^3)"},
    Key{"tissue", "law"},
    Key{"tissue", "fibre_modulus", {}, is_positive, "positive (MPa)"},
    Key{"tissue", "fibre", "it belongs to a fibre_modulus"},
    Key{"tissue", "fibre_tension_only", "it belongs to a fibre_modulus"},
    Key{"load", "gravity"},
    Key{"load", "pressure"},
    Key{"load", "before"},
    Key{"resect", "label", {}, is_not_negative, "at least 0"},
    Key{"load", "from", "it belongs to a pressure", is_not_negative, "at least 0"},
    Key{"load", "on", "it belongs to a pressure", is_not_negative, "at least 0"},
    Key{"tissue", "gray", "it belongs to [[shape]], or to labels without a picture"},
    Key{"condition", "where"},
    Key{"condition", "dx"},
    Key{"condition", "dy"},
    Key{"condition", "dz", "only volumes have it"},
    Key{"condition", "labels", "it belongs to where = \"labels\"", is_not_negative, "at least 0"},
    Key{"condition", "centre", "it belongs to where = \"labels\""},
    Key{"condition", "size", "it belongs to where = \"labels\"", is_positive,
        "positive (fractions of the image)"},
    Key{"condition", "unit"},
    Key{"condition", "outward"},
    Key{"condition", "slide"},
    Key{"condition", "normal_radius", "it belongs to slide = true", is_positive, "positive (mm)"},
    Key{"condition", "closing", "it belongs to where = \"outside\"",
        [](double value) { return value >= 0.0 && value < 1.0; }, "in [0, 1) (a fraction of the image)"},
    Key{"condition", "confidence", {}, is_share, "within 0 ... 1"},
    Key{"condition", "deviation", of_elastic, is_not_negative, "at least 0 (pixels)"},
    Key{"points", "file"},
    Key{"points", "before"},
    Key{"points", "after"},
    Key{"points", "space", "it belongs to surfaces; points say it themselves"},
    Key{"recipe", "points", {}, [](double value) { return value >= 1.0 && value <= 1e4; }, "1 ... 10000"},
    Key{"recipe", "displacement", {}, is_not_negative, "at least 0 (mm)"},
    Key{"recipe", "deviation", {}, is_not_negative, "at least 0 (mm)"},
    Key{"recipe", "moduli", {}, [](double value) { return value >= 0.0 && value <= 5.0; }, "0 ... 5"},
    Key{"recipe", "loads", {}, is_not_negative, "at least 0 (times the [[load]]s)"},
    Key{"recipe", "neo_hookean", {}, is_share, "within 0 ... 1"},
    Key{"recipe", "labels", {}, is_not_negative, "at least 0"},
    Key{"points", "deviation", of_elastic, is_not_negative, "at least 0 (mm)"},
};

/// Those above and the parameters of laws, which a scene states for all tissues or for one.
const std::vector<Key>& known_keys() {
  static std::vector<std::string> belongs;
  static const std::vector<Key> all = [] {
    std::vector<Key> found(keys_but_laws.begin(), keys_but_laws.end());
    belongs.reserve(registered_laws().size());
    for (const RegisteredLaw* const law : registered_laws()) {
      if (!law->key.empty()) {
        belongs.push_back(fmt::format("it belongs to law = \"{}\"", law->name));
        found.push_back({"", law->key, belongs.back(), is_positive, "positive"});
        found.push_back({"tissue", law->key, belongs.back(), is_positive, "positive"});
      }
    }
    return found;
  }();
  return all;
}

/// Null where the table that `where` names in errors ("[schedule]", "[[tissue]]", "") has no such key.
const Key* find_key(std::string_view where, std::string_view name) {
  const std::size_t first = std::min(where.find_first_not_of('['), where.size());
  const std::string_view table = where.substr(first, where.find(']') - first);
  const auto found = std::ranges::find_if(
      known_keys(), [&](const Key& key) { return key.table == table && key.name == name; });
  return found == known_keys().end() ? nullptr : &*found;
}

} // namespace

/// Throws InputError for a key of more parts than any scene has: tables are made and unmade by recursion, one
/// in the other for each dot, until the stack ends. What stands in quotes and in comments has no dots of
/// keys.
static void require_shallow_keys(std::string_view text, const std::string& file) {
  constexpr int most_dots = 100;
  int line = 1;
  int dots = 0;
  std::string_view quote; // that ends a text
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view rest = text.substr(i);
    line += rest.front() == '\n' ? 1 : 0;
    if (!quote.empty()) {
      const bool ends = rest.starts_with(quote) || (quote.size() == 1 && rest.front() == '\n');
      i += ends ? quote.size() - 1 : rest.front() == '\\' && quote.front() == '"' ? 1 : 0;
      quote = ends ? std::string_view() : quote;
    } else if (rest.front() == '"' || rest.front() == '\'') {
      const std::size_t length = rest.starts_with("\"\"\"") || rest.starts_with("'''") ? 3 : 1;
      quote = rest.substr(0, length);
      i += length - 1;
    } else if (rest.front() == '#') {
      i += std::min(rest.find('\n'), rest.size()) - 1;
    } else if (rest.front() == '.') {
      ++dots;
    } else if (std::string_view("=\n,[]{}").find(rest.front()) != std::string_view::npos) {
      dots = 0;
    }
    if (dots > most_dots) {
      throw InputError(fmt::format("{}:{}: a key of more than {} parts; scene files have at most two", file,
                                   line, most_dots));
    }
  }
}

toml::table parse_toml(const std::string& text, const std::string& file) {
  require_shallow_keys(text, file);
  return toml::parse(text, file);
}

TomlReader::TomlReader(const toml::table& table, std::string file, std::string where)
    : table_(table), file_(std::move(file)), where_(std::move(where)) {
  for (const auto& [name, node] : table_) {
    if (find_key(where_, name.str()) == nullptr) {
      std::vector<std::string_view> known;
      for (const Key& key : known_keys()) {
        if (find_key(where_, key.name) == &key) {
          known.push_back(key.name);
        }
      }
      const std::string all = fmt::format("those understood are {}", fmt::join(known, ", "));
      fail(name.str(),
           fmt::format("is not a key of scene files here; {}", did_you_mean(name.str(), known, all)));
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

double TomlReader::number(std::string_view key, const toml::node& node) const {
  const auto value = node.value<double>();
  if (!value || !(node.is_floating_point() || node.is_integer())) {
    fail(key, "must be a number");
  }
  if (!std::isfinite(*value)) {
    fail(key, fmt::format("is {}, it must be finite", *value));
  }
  if (const Key& known = *find_key(where_, key); known.is_right != nullptr && !known.is_right(*value)) {
    fail(key, fmt::format("is {}, it must be {}", *value, known.must_be));
  }
  return *value;
}

bool TomlReader::is_list(std::string_view key) {
  const toml::node* const node = find(key);
  return node != nullptr && node->is_array();
}

std::vector<double> TomlReader::numbers(std::string_view key, std::size_t least, std::size_t most) {
  const toml::array* array = require(key).as_array();
  if (array == nullptr || array->size() < least || array->size() > most) {
    fail(key, most > 3     ? "must be a list of numbers"
              : most == 2  ? "must be two numbers, [x, y]"
              : least == 3 ? "must be three numbers, [x, y, z]"
                           : "must be two numbers, [x, y], or three, [x, y, z]");
  }
  std::vector<double> values;
  for (const toml::node& node : *array) {
    values.push_back(number(key, node));
  }
  return values;
}

std::string TomlReader::text(std::string_view key) {
  const toml::node& node = require(key);
  if (node.is_array()) {
    return fmt::format("{}", fmt::join(numbers(key, 0, std::numeric_limits<std::size_t>::max()), ","));
  }
  if (const auto whole = node.value_exact<std::int64_t>()) {
    return std::to_string(*whole);
  }
  const auto words = node.value_exact<std::string>();
  return words ? *words : fmt::format("{}", number(key, node));
}

template <>
std::string TomlReader::get(std::string_view key) {
  const toml::node& node = require(key);
  if (!node.is_string()) {
    fail(key, "must be a text in quotes");
  }
  return *node.value<std::string>();
}

template <>
double TomlReader::get(std::string_view key) {
  return number(key, require(key));
}

template <>
bool TomlReader::get(std::string_view key) {
  const auto value = require(key).value_exact<bool>();
  if (!value) {
    fail(key, "must be true or false");
  }
  return *value;
}

template <>
int TomlReader::get(std::string_view key) {
  if (!require(key).is_integer()) {
    fail(key, "must be a whole number");
  }
  const double value = get<double>(key);
  if (std::abs(value) > 1e9) {
    fail(key, fmt::format("is {}, out of range", value));
  }
  return static_cast<int>(value);
}

template <>
std::array<double, 2> TomlReader::get(std::string_view key) {
  const std::vector<double> values = numbers(key, 2, 2);
  return {values[0], values[1]};
}

template <>
std::vector<float> TomlReader::get(std::string_view key) {
  const std::vector<double> values = numbers(key, 0, std::numeric_limits<std::size_t>::max());
  return {values.begin(), values.end()};
}

std::size_t TomlReader::choice(std::string_view key, std::span<const std::string_view> choices) {
  const auto value = get<std::string>(key);
  if (const auto found = std::ranges::find(choices, value); found != choices.end()) {
    return static_cast<std::size_t>(found - choices.begin());
  }
  fail(key, fmt::format("is \"{}\", it must be one of {}", value, fmt::join(choices, ", ")));
}

TomlReader TomlReader::table(std::string_view key) {
  const toml::node* node = find(key);
  if (node != nullptr && !node->is_table()) {
    fail(key, "must be a table");
  }
  return {node == nullptr ? empty_table : *node->as_table(), file_, fmt::format("[{}]", key)};
}

std::vector<TomlReader> TomlReader::tables(std::string_view key) {
  std::vector<TomlReader> readers;
  const toml::node* node = find(key);
  if (node == nullptr) {
    return readers;
  }
  if (!node->is_array_of_tables() && !(node->is_array() && node->as_array()->empty())) {
    fail(key, fmt::format("must be written as [[{}]]", key));
  }
  for (const toml::node& element : *node->as_array()) {
    readers.emplace_back(*element.as_table(), file_, fmt::format("[[{}]]", key));
  }
  return readers;
}

void TomlReader::refuse_unless(bool has_effect, std::string_view key) const {
  if (!has_effect && table_.contains(key)) {
    const std::string_view belongs = find_key(where_, key)->belongs;
    fail(key,
         fmt::format("has no effect in this scene{}{}; leave it out", belongs.empty() ? "" : ": ", belongs));
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
  const std::string at = line > 0 ? fmt::format(":{}", line) : ""; // what is made in memory has no lines
  throw InputError(
      fmt::format("{}{}: {}{}{} {}", file_, at, where_, where_.empty() ? "" : " ", key, message));
}

} // namespace hdmbench
