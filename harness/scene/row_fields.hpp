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

/// How values are read: each throws InputError that names the place.
namespace json_value {

template <typename Value>
concept Struct = requires(Fields& fields, Value& value) {
  list_fields(fields, value);
};
template <typename Value>
concept List = std::ranges::sized_range<Value> && !std::same_as<Value, std::string>;

/// Index of the text among `names`.
std::size_t read_name(const nlohmann::json& found, const JsonPlace& place,
                      std::span<const std::string_view> names);
/// 0 ... `most`.
std::int64_t read_count(const nlohmann::json& found, const JsonPlace& place, std::int64_t most);
void require_array(const nlohmann::json& found, const JsonPlace& place);

template <typename Value>
void read(const nlohmann::json& found, const JsonPlace& place, Value& value);

template <typename Value>
void read(const nlohmann::json& found, const JsonPlace& place, std::optional<Value>& value) {
  value.reset();
  if (!found.is_null()) {
    read(found, place, value.emplace());
  }
}

/// `read_element` reads an element into a reference.
template <typename Values, typename Read>
void read_list(const nlohmann::json& found, const JsonPlace& place, Values& values,
               const Read& read_element) {
  require_array(found, place);
  if constexpr (requires { values.resize(found.size()); }) {
    values.resize(found.size());
  } else if (values.size() != found.size()) {
    place.fail(fmt::format("must have {} values, but has {}", values.size(), found.size()));
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    read_element(found[i], place.element(i), values[i]);
  }
}

template <typename Numbers>
void read(const nlohmann::json& found, const JsonPlace& place, NullIsNan<Numbers>& value) {
  if constexpr (List<Numbers>) {
    read_list(found, place, value.value, [](const auto& element, const JsonPlace& at, auto& number) {
      NullIsNan own{number};
      read(element, at, own);
    });
  } else if (found.is_null()) {
    value.value = std::nanf("");
  } else {
    read(found, place, value.value);
  }
}

template <typename Value>
void read(const nlohmann::json& found, const JsonPlace& place, Value& value) {
  if constexpr (Struct<Value>) {
    read_json_row(found, place, value);
  } else if constexpr (List<Value>) {
    read_list(found, place, value,
              [](const auto& element, const JsonPlace& at, auto& own) { read(element, at, own); });
  } else if constexpr (std::is_enum_v<Value>) {
    value = static_cast<Value>(read_name(found, place, names_of(Value())));
  } else if constexpr (std::integral<Value> && !std::same_as<Value, bool>) {
    constexpr auto most = static_cast<std::int64_t>(
        std::min<std::uint64_t>(std::numeric_limits<Value>::max(), std::numeric_limits<std::int64_t>::max()));
    value = static_cast<Value>(read_count(found, place, most));
  } else {
    try {
      found.get_to(value);
    } catch (const nlohmann::json::exception&) {
      place.fail(fmt::format("must be {}, but is {}",
                             std::same_as<Value, bool>    ? "true or false"
                             : std::floating_point<Value> ? "a number"
                                                          : "a string",
                             found.type_name()));
    }
  }
}

} // namespace json_value

template <json_value::Struct Row>
void to_json(nlohmann::json& written, const Row& row) {
  written = to_json_row(row);
}
template <typename Enumeration>
requires std::is_enum_v<Enumeration> && requires {
  names_of(Enumeration());
}
void to_json(nlohmann::json& written, const Enumeration& value) {
  written = names_of(value).at(static_cast<std::size_t>(value));
}
template <typename Numbers>
void to_json(nlohmann::json& written, const NullIsNan<Numbers>& numbers) {
  written = numbers.value;
}

template <typename Value>
void Fields::operator()(std::string_view key, Value&& value) {
  if (reading()) {
    json_value::read(required(key), place_.key(key), value);
  } else {
    (*written_)[std::string(key)] = value;
  }
}

template <typename Value>
void Fields::if_any(std::string_view key, Value&& value) {
  const nlohmann::json found = reading() ? nlohmann::json() : nlohmann::json(value);
  if (reading() ? has(key) : !found.empty() && found != "") {
    (*this)(key, value);
  }
}

} // namespace hdmbench
