#include "harness/check/failing_calls_row.hpp"

#include "harness/scene/row_fields.hpp"

namespace hdmbench {

void list_fields(Fields& fields, FailingCallsRow& row) {
  fields("backend", row.backend);
  fields("api", row.api);
  fields("kind", row.kind);
  fields("calls", row.calls);
  fields("failed", row.failed);
  fields("clean", row.clean);
  fields("succeeded", row.succeeded);
  fields("went_on", row.went_on);
  fields("unclean", row.unclean);
}

} // namespace hdmbench
