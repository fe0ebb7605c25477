#include "harness/check/failing_calls_row.hpp"

#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>

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
  if (static_cast<double>(row.failed) != ended) {
    throw Contradiction{"failed", fmt::format("is {}, but {} are accounted for", row.failed, ended)};
  }
  if (row.clean + row.succeeded > row.calls) {
    throw Contradiction{"calls", fmt::format("is {}, less than what failed cleanly", row.calls)};
  }
  if (row.went_on > row.clean) {
    throw Contradiction{"went_on", fmt::format("is {}, more than the clean errors", row.went_on)};
  }
}

} // namespace hdmbench
