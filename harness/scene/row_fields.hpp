#pragma once

#include "harness/scene/placement.hpp"

#include <nlohmann/json.hpp>

#include <optional>

/// What rows of result files are written with beside nlohmann's own.
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

/// "direction" has the unit vectors along rows, along columns and through slices.
void to_json(nlohmann::json& written, const Placement& placement);

/// Without the members of objects that are null, at any depth.
[[nodiscard]] nlohmann::json without_nulls(nlohmann::json value);

} // namespace hdmbench
