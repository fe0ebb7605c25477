#include "harness/measure/scaling_row.hpp"

#include "harness/scene/row_fields.hpp"

namespace hdmbench {

void list_fields(Fields& fields, ScalingRow& row) {
  fields("scene", row.scene);
  fields("energy", row.energy);
  fields("scaling", row.scaling);
  fields("backend", row.backend);
  fields("ranks", row.ranks);
  fields("width", row.width);
  fields("height", row.height);
  fields("seconds", row.seconds);
  fields("messages", row.messages);
  fields("bytes", row.bytes);
  fields("message_seconds", row.message_seconds);
}

} // namespace hdmbench
