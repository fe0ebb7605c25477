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

void require_consistent(const FailingCallsRow& row) {
  const double ended = static_cast<double>(row.clean) + static_cast<double>(row.succeeded) +
                       static_cast<double>(row.unclean.size());
  refuse_if(static_cast<double>(row.failed) != ended, "failed", "is {}, but {} are accounted for", row.failed,
            ended);
  refuse_if(row.clean + row.succeeded > row.calls, "calls", "is {}, less than what failed cleanly",
            row.calls);
  refuse_if(row.went_on > row.clean, "went_on", "is {}, more than the clean errors", row.went_on);
}

} // namespace hdmbench
