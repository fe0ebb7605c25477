#include "harness/measure/instructions_row.hpp"

#include "harness/scene/row_fields.hpp"

namespace hdmbench {

void list_fields(Fields& fields, InstructionsRow& row) {
  fields("group", row.group);
  fields("shader", row.shader);
  fields("candidates", row.candidates);
  fields("energies", row.energies);
  fields("instructions", row.instructions);
  fields("texture_instructions", row.texture_instructions);
  fields("temporaries", row.temporaries);
  fields("flow_control", row.flow_control);
  fields("refusal", row.refusal);
  fields("scalar_operations", row.scalar_operations);
  fields("device", row.device);
  fields("driver", row.driver);
  fields("instructions_limit", row.instructions_limit);
  fields("temporaries_limit", row.temporaries_limit);
}

} // namespace hdmbench
