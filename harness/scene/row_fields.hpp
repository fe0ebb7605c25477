#pragma once

#include "harness/scene/placement.hpp"
#include "kernels/data/field.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <utility>

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

/// "direction" has the unit vectors along rows, along columns and through slices; "aspect" the sides of a
/// pixel over the shortest one, where they are not the same.
inline void to_json(nlohmann::json& written, const Placement& placement) {
  written = {{"origin", placement.origin}, {"direction", placement.axes}, {"thickness", placement.thickness}};
  if (placement.aspect != Placement{}.aspect) {
    written["aspect"] = placement.aspect;
  }
}

/// The row with its "width", "height" and, of a volume, "depth": how all rows tell a size.
[[nodiscard]] inline nlohmann::json with_size(nlohmann::json row, Extent extent) {
  row.update({{"width", extent.width}, {"height", extent.height}});
  if (extent.depth > 1) {
    row["depth"] = extent.depth;
  }
  return row;
}

/// Without the members of objects that are null, at any depth. As deep as our own documents, so recursion
/// does.
// NOLINTNEXTLINE(misc-no-recursion)
[[nodiscard]] inline nlohmann::json without_nulls(nlohmann::json value) {
  for (auto member = value.begin(); value.is_structured() && member != value.end();) {
    if (value.is_object() && member->is_null()) {
      member = value.erase(member);
    } else {
      *member = without_nulls(std::move(*member));
      ++member;
    }
  }
  return value;
}

} // namespace hdmbench
