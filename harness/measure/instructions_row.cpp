#include "harness/measure/instructions_row.hpp"

#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>

#include <array>

namespace hdmbench {

void list_fields(Fields& fields, InstructionsRow& row) {
  static constexpr std::array<std::string_view, 3> groups{"candidates", "methods", "vectors"};
  fields("group", OneOf{row.group, groups});
  fields("shader", row.shader);
  fields("candidates", row.candidates);
  fields("energies", row.energies);
  fields.newer("instructions", row.instructions);
  fields.newer("texture_instructions", row.texture_instructions);
  fields.newer("temporaries", row.temporaries);
  fields.newer("flow_control", row.flow_control);
  fields("refusal", row.refusal);
  fields.newer("scalar_operations", row.scalar_operations);
  fields("device", row.device);
  fields("driver", row.driver);
  fields("instructions_limit", row.instructions_limit);
  fields.newer("temporaries_limit", row.temporaries_limit);
}

void require_consistent(const InstructionsRow& row) {
  refuse_if(row.instructions.has_value() != row.refusal.empty(), "refusal",
            "must say why where there are no instructions, and only there");
  if (row.instructions && *row.instructions > row.instructions_limit) {
    throw Contradiction{"instructions", fmt::format("are {} although the limit is {}", *row.instructions,
                                                    row.instructions_limit)};
  }
}

} // namespace hdmbench
