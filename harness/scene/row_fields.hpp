#pragma once

#include "harness/scene/placement.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <ranges>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

/// Rows of result files. One that is only written has its keys in NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE. One
/// that this program reads again from files of people is a struct whose fields one function lists, from which
/// it is both written and read, with messages that name file and key:
///
///     struct TimingRow { std::string scene; std::optional<double> seconds; };
///     void list_fields(Fields& fields, TimingRow& row) {
///       fields("scene", row.scene);
///       fields.newer("seconds", row.seconds);
///     }
///     void require_consistent(const TimingRow& row); // where there is more to check; throws Contradiction
///
/// A field is a flag, a count (>= 0), a number, a text, an enumerator, another such struct, or an optional,
/// array or vector of these. An enumeration E has its names, in the order of its enumerators, in
///
///     constexpr const auto& names_of(E) { return names; } // an array of std::string_view
namespace nlohmann {

/// null where there is none.
template <typename Value>
struct adl_serializer<std::optional<Value>> {
  static void to_json(json& written, const std::optional<Value>& value) {
    written = value ? json(*value) : json();
  }
  static void from_json(const json& read, std::optional<Value>& value) {
    value = read.is_null() ? std::nullopt : std::optional(read.get<Value>());
  }
};

} // namespace nlohmann

namespace hdmbench {

/// A row says two things that cannot both be true.
struct Contradiction {
  std::string key;  ///< of the row: "seconds"
  std::string what; ///< the sentence that begins with the key: "must be greater than 0"
};

/// Throws Contradiction where a row is wrong about its `key`; `what` and `parts` are fmt's.
template <typename... Parts>
void refuse_if(bool is_wrong, std::string_view key, fmt::format_string<const Parts&...> what,
               const Parts&... parts) {
  if (is_wrong) {
    throw Contradiction{std::string(key), fmt::format(what, parts...)};
  }
}

/// Where a value stands: "results[3].seconds" of a file.
struct JsonPlace {
  std::filesystem::path file;
  std::string path{};

  [[nodiscard]] JsonPlace key(std::string_view name) const;
  [[nodiscard]] JsonPlace element(std::size_t index) const;
  /// Throws InputError naming file and path.
  [[noreturn]] void fail(std::string_view what) const;
};

/// Numbers that are null in the file where they are not finite, and NaN when read: one, an array or a vector.
template <typename Numbers>
struct NullIsNan {
  Numbers& value;
};
template <typename Numbers>
NullIsNan(Numbers&) -> NullIsNan<Numbers>;

/// One JSON object that is written or read.
class Fields {
public:
  /// Writes into `object`.
  explicit Fields(nlohmann::json& object) : written_(&object) { object = nlohmann::json::object(); }
  /// Reads `object`, which must outlive this. Throws InputError where it is no object.
  Fields(const nlohmann::json& object, JsonPlace place);

  /// A key that is always there; null is an optional without a value. Throws InputError naming file and key
  /// where it is missing or its value has another type, as the next two do.
  template <typename Value>
  void operator()(std::string_view key, Value&& value);

  /// A key that files of before do not have, or have null: then `value` stays as it is.
  template <typename Value>
  void newer(std::string_view key, Value&& value) {
    if (!reading() || has(key)) {
      (*this)(key, value);
    }
  }

  /// A key that is left out where there is nothing: an optional without a value, an empty text or list.
  template <typename Value>
  void if_any(std::string_view key, Value&& value);

  [[nodiscard]] bool reading() const { return written_ == nullptr; }

private:
  [[nodiscard]] const nlohmann::json& required(std::string_view key) const;
  /// Whether the key is there and not null.
  [[nodiscard]] bool has(std::string_view key) const;

  nlohmann::json* written_ = nullptr;
  const nlohmann::json* read_ = nullptr;
  JsonPlace place_{};
};

/// "direction" has the unit vectors along rows, along columns and through slices.
void to_json(nlohmann::json& written, const Placement& placement);

/// Without the members of objects that are null, at any depth.
[[nodiscard]] nlohmann::json without_nulls(nlohmann::json value);

/// `row` as it stands in a file.
template <typename Row>
[[nodiscard]] nlohmann::json to_json_row(Row row) {
  if constexpr (requires(Fields & fields) { list_fields(fields, row); }) {
    nlohmann::json object;
    Fields fields(object);
    list_fields(fields, row);
    return object;
  } else {
    return without_nulls(row);
  }
}

/// Throws InputError for what is missing, mistyped or contradicts itself.
template <typename Row>
void read_json_row(const nlohmann::json& object, const JsonPlace& place, Row& row) {
  Fields fields(object, place);
  try {
    list_fields(fields, row);
    if constexpr (requires { require_consistent(row); }) {
      require_consistent(row);
    }
  } catch (const Contradiction& contradiction) {
    place.key(contradiction.key).fail(contradiction.what);
  }
}

/// Of a row with samples: at least one, all greater than 0, the median between them. Throws Contradiction.
void require_samples(const std::vector<double>& seconds, const std::optional<double>& median);

/// What a type of value is in JSON: its name in messages, whether a value is one, and the value.
namespace json_value {

/// Throws InputError that says what was wanted and what is there.
[[noreturn]] void fail_type(const nlohmann::json& found, const JsonPlace& place, const std::string& wanted);
/// Throws InputError unless it is 0 to `most`.
void require_count(const nlohmann::json& found, const JsonPlace& place, std::uint64_t most);
/// Index of the text among `names`; throws InputError that lists them.
std::size_t require_name(const nlohmann::json& found, const JsonPlace& place,
                         std::span<const std::string_view> names);
void require_size(const nlohmann::json& found, const JsonPlace& place, std::size_t size);

template <typename Value>
concept Optional = std::same_as<Value, std::optional<typename Value::value_type>>;
template <typename Value>
concept List = std::ranges::sized_range<Value> && !std::same_as<Value, std::string>;
template <typename Value>
concept Struct = requires(Fields& fields, Value& value) {
  list_fields(fields, value);
};

template <typename Value>
std::string name() {
  if constexpr (Struct<Value>) {
    return "an object";
  } else if constexpr (Optional<Value>) {
    return name<typename Value::value_type>() + " or null";
  } else if constexpr (List<Value>) {
    return "an array, each " + name<typename Value::value_type>();
  } else if constexpr (std::same_as<Value, bool>) {
    return "true or false";
  } else if constexpr (std::integral<Value>) {
    return "an integer";
  } else {
    return std::floating_point<Value> ? "a number" : "a string";
  }
}

/// Structs in a list tell each for itself.
template <typename Value>
bool is(const nlohmann::json& found) {
  if constexpr (Struct<Value>) {
    return found.is_object();
  } else if constexpr (Optional<Value>) {
    return found.is_null() || is<typename Value::value_type>(found);
  } else if constexpr (List<Value>) {
    return found.is_array() &&
           (Struct<typename Value::value_type> || std::ranges::all_of(found, is<typename Value::value_type>));
  } else if constexpr (std::same_as<Value, bool>) {
    return found.is_boolean();
  } else if constexpr (std::integral<Value>) {
    return found.is_number_integer();
  } else {
    return std::floating_point<Value> ? found.is_number() : found.is_string();
  }
}

template <typename Value>
void read(const nlohmann::json& found, const JsonPlace& place, Value& value);
template <typename Numbers>
void read(const nlohmann::json& found, const JsonPlace& place, NullIsNan<Numbers>& value);

template <typename Values>
void resize_as(const nlohmann::json& found, const JsonPlace& place, Values& values) {
  if constexpr (requires { values.resize(found.size()); }) {
    values.resize(found.size());
  }
  require_size(found, place, values.size());
}

template <typename Value>
void read(const nlohmann::json& found, const JsonPlace& place, Value& value) {
  if (!is<Value>(found)) {
    fail_type(found, place, name<Value>());
  }
  if constexpr (Struct<Value>) {
    read_json_row(found, place, value);
  } else if constexpr (Optional<Value>) {
    value.reset();
    if (!found.is_null()) {
      read(found, place, value.emplace());
    }
  } else if constexpr (List<Value>) {
    resize_as(found, place, value);
    for (std::size_t i = 0; i < found.size(); ++i) {
      read(found[i], Struct<typename Value::value_type> ? place.element(i) : place, value[i]);
    }
  } else if constexpr (std::is_enum_v<Value>) {
    value = static_cast<Value>(require_name(found, place, names_of(Value())));
  } else {
    if constexpr (std::integral<Value> && !std::same_as<Value, bool>) {
      require_count(found, place, static_cast<std::uint64_t>(std::numeric_limits<Value>::max()));
    }
    value = found.get<Value>();
  }
}

template <typename Numbers>
void read(const nlohmann::json& found, const JsonPlace& place, NullIsNan<Numbers>& value) {
  if constexpr (List<Numbers>) {
    if (!is<std::vector<std::optional<double>>>(found)) {
      fail_type(found, place, name<std::vector<std::optional<double>>>());
    }
    resize_as(found, place, value.value);
    for (std::size_t i = 0; i < found.size(); ++i) {
      value.value[i] = found[i].is_null() ? std::nanf("") : found[i].get<typename Numbers::value_type>();
    }
  } else {
    std::optional<Numbers> number;
    read(found, place, number);
    value.value = number.value_or(std::nanf(""));
  }
}

template <typename Value>
nlohmann::json write(Value& value) {
  if constexpr (requires { value.value; } && !Optional<Value>) { // one of the wrappers
    return write(value.value);
  } else if constexpr (Struct<Value>) {
    return to_json_row(value);
  } else if constexpr (Optional<Value>) {
    return value ? write(*value) : nlohmann::json();
  } else if constexpr (List<Value>) {
    nlohmann::json list = nlohmann::json::array();
    for (auto& element : value) {
      list.push_back(write(element));
    }
    return list;
  } else if constexpr (std::is_enum_v<Value>) {
    return names_of(value).at(static_cast<std::size_t>(value));
  } else {
    return value;
  }
}

template <typename Value>
bool is_nothing(const Value& value) {
  if constexpr (requires { value.value; } && !Optional<Value>) {
    return is_nothing(value.value);
  } else if constexpr (Optional<Value>) {
    return !value;
  } else {
    return value.empty();
  }
}

} // namespace json_value

template <typename Value>
void Fields::operator()(std::string_view key, Value&& value) {
  if (reading()) {
    json_value::read(required(key), place_.key(key), value);
  } else {
    (*written_)[std::string(key)] = json_value::write(value);
  }
}

template <typename Value>
void Fields::if_any(std::string_view key, Value&& value) {
  if (reading() ? has(key) : !json_value::is_nothing(value)) {
    (*this)(key, value);
  }
}

} // namespace hdmbench
