#include "harness/report/bench_results.hpp"

#include "harness/report/json_reader.hpp"

namespace hdmbench::report {

namespace {

// Not in files of before it was written.
std::optional<double> number_if_there(const JsonReader& json, const std::string& key) {
  return json.has(key) ? json.number_or_null(key) : std::nullopt;
}

void read_limits(const JsonReader& json, BenchRow& row) {
  if (json.holds("threads")) {
    row.threads = json.count("threads");
  }
  row.active = json.has("work") && json.text("work", {"dense", "active"}) == "active";
  row.bytes_per_site_update = number_if_there(json, "bytes_per_site_update");
  row.operations_per_site_update = number_if_there(json, "operations_per_site_update");
  row.gigabytes_per_second = number_if_there(json, "gigabytes_per_second");
  row.gigaoperations_per_second = number_if_there(json, "gigaoperations_per_second");
  row.percent_of_ceiling = number_if_there(json, "percent_of_ceiling");
  row.binding = json.holds("binding") ? json.text("binding", {"memory", "arithmetic"}) : "";
  if (json.holds("ceiling")) {
    const JsonReader ceiling = json.object("ceiling");
    row.ceiling_gigabytes_per_second = number_if_there(ceiling, "copy_gigabytes_per_second");
    row.ceiling_gigaoperations_per_second = number_if_there(ceiling, "gigaoperations_per_second");
  }
  row.peak_memory_bytes = number_if_there(json, "peak_memory_bytes");
  row.bytes_per_site = number_if_there(json, "bytes_per_site");
  row.speed_up_over_dense = number_if_there(json, "speed_up_over_dense");
}

} // namespace

BenchRow read_bench(const JsonReader& json) {
  BenchRow row;
  row.scene = json.text("scene");
  row.width = json.count("width");
  row.height = json.count("height");
  row.backend = json.text("backend");
  row.device = json.text("device");
  row.method = json.text("method");
  row.iterations = json.count("iterations");
  row.seconds = json.numbers("seconds");
  row.seconds_median = json.number_or_null("seconds_median");
  row.msites_per_second = json.number_or_null("msites_per_second");
  row.setup_seconds = json.number_or_null("setup_seconds");
  row.projection_seconds = json.number_or_null("projection_seconds");
  row.upload_seconds = json.number_or_null("upload_seconds");
  row.compute_seconds = json.number_or_null("compute_seconds");
  row.readback_seconds = json.number_or_null("readback_seconds");
  row.speed_up_over_scalar = json.number_or_null("speed_up_over_scalar");
  row.checked = !json.has("valid") || json.holds("valid"); // null: nothing was compared
  row.valid = !row.checked || json.flag("valid");
  row.reason = json.text("reason");
  read_limits(json, row);

  if (!row.valid) {
    row.speed_up_over_scalar.reset();
    row.speed_up_over_dense.reset();
    return row;
  }
  if (!row.checked) {
    row.speed_up_over_scalar.reset();
  }
  if (row.width == 0 || row.height == 0) {
    json.fail("width", "and \"height\" of a valid row must be at least 1");
  }
  require_samples(json, row.seconds, row.seconds_median);
  return row;
}

} // namespace hdmbench::report
