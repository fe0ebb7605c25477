#include "harness/scene/row_fields.hpp"

namespace hdmbench {

void to_json(nlohmann::json& written, const Placement& placement) {
  written = {{"origin", placement.origin}, {"direction", placement.axes}, {"thickness", placement.thickness}};
}

// As deep as our own documents, so recursion does.
// NOLINTNEXTLINE(misc-no-recursion)
nlohmann::json without_nulls(nlohmann::json value) {
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
