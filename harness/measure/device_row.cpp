#include "harness/measure/device_row.hpp"

#include "harness/measure/choices.hpp"
#include "harness/scene/row_fields.hpp"

namespace hdmbench {

void list_fields(Fields& fields, DeviceRow& row) {
  fields("backend", row.backend);
  fields("description", row.description);
  fields("updates", row.updates);
  fields("available", row.available);
  fields("device", row.device);
  fields("driver", row.driver);
  fields("software", row.software);
  fields("reason", row.reason);
  fields.newer("choices", row.choices);
}

} // namespace hdmbench
