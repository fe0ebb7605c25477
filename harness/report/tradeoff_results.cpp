#include "harness/report/tradeoff_results.hpp"

#include "harness/report/json_reader.hpp"

namespace hdmbench::report {

namespace {

template <typename Row>
void read_scene(const JsonReader& json, Row& row) {
  row.scene = json.text("scene");
  row.width = json.count("width");
  row.height = json.count("height");
  row.poisson = json.number("poisson");
}

std::optional<double> read_optional(const JsonReader& json, const std::string& key) {
  const std::optional<double> value = json.has(key) ? json.number_or_null(key) : std::nullopt;
  if (value && *value < 0.0) {
    json.fail(key, "must not be negative");
  }
  return value;
}

std::optional<EqualAccuracyRow::Entry> read_entry(const JsonReader& json, const std::string& key) {
  const auto entry = json.object_or_null(key);
  if (!entry) {
    return std::nullopt;
  }
  EqualAccuracyRow::Entry result{.method = entry->text("method"),
                                 .effort = entry->text("effort"),
                                 .backend = entry->text("backend"),
                                 .seconds_median = entry->number("seconds_median")};
  if (key != "ours") {
    result.ratio = entry->number("ratio");
    result.ratio_low = entry->number("ratio_low");
    result.ratio_high = entry->number("ratio_high");
    if (!(result.ratio_low <= result.ratio && result.ratio <= result.ratio_high)) {
      entry->fail("ratio", "must lie between \"ratio_low\" and \"ratio_high\"");
    }
  }
  return result;
}

} // namespace

TradeoffRow read_tradeoff(const JsonReader& json) {
  TradeoffRow row;
  read_scene(json, row);
  row.method = json.text("method");
  row.is_rival = json.flag("rival");
  row.effort = json.text("effort");
  row.poisson_used = json.has("poisson_used") ? json.number_or_null("poisson_used") : std::nullopt;
  row.backend = json.text("backend");
  row.device = json.text("device");
  row.command = json.text("command");
  row.status = json.text("status", {"ok", "unverified", "failed", "skipped"});
  row.reason = json.text("reason");
  row.seconds = json.numbers("seconds");
  row.seconds_median = read_optional(json, "seconds_median");
  row.fine_sweep_equivalents = read_optional(json, "fine_sweep_equivalents");
  row.asked = read_optional(json, "asked");
  row.estimated = read_optional(json, "estimated_error");
  row.to_fem_nu0 = read_optional(json, "rmsd_to_fem_nu0");
  row.to_fem = read_optional(json, "rmsd_to_fem");
  row.to_fixed_point = read_optional(json, "rmsd_to_fixed_point");
  if (row.status == "ok") {
    require_samples(json, row.seconds, row.seconds_median);
    if (!row.to_fem_nu0 || !row.to_fem || !row.to_fixed_point) {
      json.fail("status", "is \"ok\" although a distance is missing");
    }
  } else if (row.reason.empty()) {
    json.fail("reason", "must say why the status is not \"ok\"");
  }
  return row;
}

EqualAccuracyRow read_equal_accuracy(const JsonReader& json) {
  EqualAccuracyRow row;
  read_scene(json, row);
  row.target = json.number("target");
  row.nearest = json.number_or_null("nearest");
  row.ours = read_entry(json, "ours");
  row.direct = read_entry(json, "direct");
  row.iterative = read_entry(json, "iterative");
  row.coarse = read_entry(json, "coarse");
  return row;
}

} // namespace hdmbench::report
