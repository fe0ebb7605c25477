#include "harness/report/golden_results.hpp"

#include "harness/report/json_reader.hpp"

namespace hdmbench::report {

GoldenRow read_golden(const JsonReader& json) {
  GoldenRow row;
  row.scene = json.text("scene");
  row.width = json.count("width");
  row.height = json.count("height");
  row.method = json.text("method");
  row.backend = json.text("backend");
  row.device = json.text("device");
  row.inputs_reason = json.text("inputs_reason");
  row.verdict = json.text("verdict", {"agree", "disagree", "mistrusted", "skipped"});
  row.reason = json.text("reason");
  for (const JsonReader& level : json.objects("levels")) {
    row.hash = level.text("hash");
  }
  if (row.verdict == "agree" && row.hash.empty()) {
    json.fail("verdict", "is \"agree\" although there is no level");
  }
  if (row.verdict == "agree" && json.holds("first_difference")) {
    json.fail("verdict", "is \"agree\" although a level differs");
  }
  if (row.verdict == "agree" && !row.inputs_reason.empty()) {
    json.fail("verdict", "is \"agree\" although the inputs are not golden");
  }
  return row;
}

} // namespace hdmbench::report
