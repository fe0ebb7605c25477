#include "harness/report/compare_results.hpp"

#include "harness/comparison/verdict.hpp"
#include "harness/report/json_reader.hpp"

namespace hdmbench::report {

namespace {

void read_comparison(const JsonReader& json, CompareRow& row) {
  row.verdict = json.text("verdict", {comparison::change_names.begin(), comparison::change_names.end()});
  row.ratio = json.number("ratio");
  row.ratio_low = json.number("ratio_low");
  row.ratio_high = json.number("ratio_high");
  row.coverage = json.number("coverage");
  row.p = json.number("p");
  row.old_spread = json.number("old_spread");
  row.new_spread = json.number("new_spread");
  row.largest_good_spread = json.number("largest_good_spread");
  row.slower_than_tolerated = json.flag("slower_than_tolerated");
  if (row.old_seconds.empty() || row.new_seconds.empty()) {
    json.fail("compared", "is true although a side has no seconds");
  }
  if (row.ratio_low <= 0.0 || row.ratio < row.ratio_low || row.ratio > row.ratio_high) {
    json.fail("ratio", "must be greater than 0 and lie in its interval");
  }
  if (row.slower_than_tolerated && (row.verdict != "slower" || row.ratio <= 1.0)) {
    json.fail("slower_than_tolerated", "contradicts the verdict or the ratio");
  }
}

} // namespace

CompareRow read_compare(const JsonReader& json) {
  CompareRow row;
  row.scene = json.text("scene");
  row.width = json.count("width");
  row.height = json.count("height");
  row.backend = json.text("backend");
  row.device = json.text("device");
  row.method = json.text("method");
  if (json.holds("threads")) {
    row.threads = json.count("threads");
  }
  row.old_commit = json.has("old_commit") ? json.text("old_commit") : "";
  row.new_commit = json.has("new_commit") ? json.text("new_commit") : "";
  row.tolerance = json.has("tolerance") ? json.number_or_null("tolerance") : std::nullopt;
  row.interleaved = json.has("interleaved") && json.flag("interleaved");
  row.old_seconds = json.numbers("old_seconds");
  row.new_seconds = json.numbers("new_seconds");
  row.remark = json.text("remark");
  row.compared = json.flag("compared");
  if (row.compared) {
    read_comparison(json, row);
  } else if (row.remark.empty()) {
    json.fail("remark", "must say why the row is not compared");
  }
  return row;
}

} // namespace hdmbench::report
