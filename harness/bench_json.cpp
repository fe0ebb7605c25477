#include "harness/bench_json.hpp"

#include "harness/choices.hpp"
#include "harness/median.hpp"

#include <algorithm>

namespace hdmbench {

namespace {

using nlohmann::json;

template <typename Value>
json or_null(const std::optional<Value>& value) {
  return value ? json(*value) : json();
}

json in_giga(const std::vector<double>& rates) {
  json values = json::array();
  std::ranges::transform(rates, std::back_inserter(values), [](double rate) { return rate * 1e-9; });
  return values;
}

json to_json(const Ceilings& ceilings) {
  return {{"copy_gigabytes_per_second", median(ceilings.copy_bytes_per_second) * 1e-9},
          {"gigaoperations_per_second", median(ceilings.operations_per_second) * 1e-9},
          {"copy_samples", in_giga(ceilings.copy_bytes_per_second)},
          {"operation_samples", in_giga(ceilings.operations_per_second)}};
}

/// Of a solution's cost: per site update, and per second of compute.
void add_cost(const BenchResult& result, json& row) {
  const double seconds =
      median_seconds(result.samples, [](const Timings& timings) { return timings.compute; });
  for (const char* key : {"bytes_per_site_update", "operations_per_site_update", "gigabytes_per_second",
                          "gigaoperations_per_second", "percent_of_ceiling", "binding"}) {
    row[key] = nullptr;
  }
  if (result.cost && result.site_updates > 0.0 && seconds > 0.0) {
    row["bytes_per_site_update"] = result.cost->bytes / result.site_updates;
    row["operations_per_site_update"] = result.cost->operations / result.site_updates;
    row["gigabytes_per_second"] = result.cost->bytes / seconds * 1e-9;
    row["gigaoperations_per_second"] = result.cost->operations / seconds * 1e-9;
  }
  if (result.share) {
    row["percent_of_ceiling"] = result.share->percent;
    row["binding"] = result.share->binding == Binding::memory ? "memory" : "arithmetic";
  }
  row["ceiling"] = result.ceilings ? to_json(*result.ceilings) : json();
}

} // namespace

double msites_per_second(const BenchResult& result) {
  const double seconds =
      median_seconds(result.samples, [](const Timings& timings) { return timings.compute; });
  return seconds > 0.0 ? result.site_updates / seconds * 1e-6 : 0.0;
}

std::string bench_method_name(const Scene& scene, const BenchResult& result) {
  return method_name(scene.schedule) + (result.work == Work::active ? "-active" : "");
}

json to_json(const Scene& scene, const BenchResult& result) {
  const auto part = [&](double (*which)(const Timings&)) { return median_seconds(result.samples, which); };
  json seconds = json::array();
  std::ranges::transform(result.samples, std::back_inserter(seconds), &Timings::total);
  json row{{"scene", scene.name},
           {"width", scene.extent().width},
           {"height", scene.extent().height},
           {"backend", result.backend},
           {"device", result.device.name},
           {"method", bench_method_name(scene, result)},
           {"work", work_names[static_cast<std::size_t>(result.work)]},
           {"threads", result.threads > 0 ? json(result.threads) : json()},
           {"effort", scene.schedule.iterations},
           {"iterations", result.iterations},
           {"fine_sweep_equivalents", result.site_updates / static_cast<double>(scene.extent().sites())},
           {"seconds", seconds},
           {"seconds_median", part([](const Timings& timings) { return timings.total(); })},
           {"msites_per_second", msites_per_second(result)},
           {"setup_seconds", result.setup_seconds},
           {"projection_seconds", part([](const Timings& timings) { return timings.projection; })},
           {"upload_seconds", part([](const Timings& timings) { return timings.upload; })},
           {"compute_seconds", part([](const Timings& timings) { return timings.compute; })},
           {"readback_seconds", part([](const Timings& timings) { return timings.readback; })},
           {"reference", result.reference.empty() ? json() : json(result.reference)},
           {"speed_up_over_scalar", result.reference == "scalar" ? or_null(result.speed_up) : json()},
           {"speed_up_over_dense", or_null(result.speed_up_over_dense)},
           {"valid", !result.reference.empty() || result.samples.empty() ? json(result.valid) : json()},
           {"reason", result.reason},
           {"peak_memory_bytes", or_null(result.peak_memory_bytes)},
           {"bytes_per_site", or_null(result.bytes_per_site)}};
  row["choices"] = nlohmann::json::array();
  for (const Choice& choice : result.choices) {
    row["choices"].push_back(to_json(choice));
  }
  add_cost(result, row);
  return row;
}

} // namespace hdmbench
