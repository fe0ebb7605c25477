#include "harness/report/failing_calls_results.hpp"

#include "harness/report/json_reader.hpp"

#include <fmt/format.h>

namespace hdmbench::report {

FailingCallsRow read_failing_calls(const JsonReader& json) {
  FailingCallsRow row;
  row.backend = json.text("backend");
  row.api = json.text("api");
  row.kind = json.text("kind");
  row.calls = json.count("calls");
  row.failed = json.count("failed");
  row.clean = json.count("clean");
  row.succeeded = json.count("succeeded");
  row.went_on = json.count("went_on");
  row.unclean = json.texts("unclean");
  const std::int64_t ended = row.clean + row.succeeded + static_cast<std::int64_t>(row.unclean.size());
  if (row.failed != ended) {
    json.fail("failed", fmt::format("is {}, but {} are accounted for", row.failed, ended));
  }
  if (row.clean + row.succeeded > row.calls) {
    json.fail("calls", fmt::format("is {}, less than what failed cleanly", row.calls));
  }
  if (row.went_on > row.clean) {
    json.fail("went_on", fmt::format("is {}, more than the clean errors", row.went_on));
  }
  return row;
}

} // namespace hdmbench::report
