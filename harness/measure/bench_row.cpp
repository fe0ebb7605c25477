#include "harness/measure/bench.hpp"
#include "harness/measure/device_row.hpp"
#include "harness/scene/row_fields.hpp"

#include <algorithm>
#include <iterator>

namespace hdmbench {

namespace {

using nlohmann::json;

constexpr double giga = 1e-9; ///< 10^9 of a unit in one

json in_giga(const std::vector<double>& rates) {
  json values = json::array();
  std::ranges::transform(rates, std::back_inserter(values), [](double rate) { return rate * giga; });
  return values;
}

/// Of a solution's cost per site update and per second of compute, and what the device can do at most.
void add_cost(const BenchResult& result, json& row) {
  for (const char* const key : {"bytes_per_site_update", "operations_per_site_update", "gigabytes_per_second",
                                "gigaoperations_per_second", "percent_of_ceiling", "binding", "ceiling"}) {
    row[key] = nullptr;
  }
  const double seconds = median_seconds(result.samples, &Timings::compute);
  if (result.cost && result.site_updates > 0.0 && seconds > 0.0) {
    row["bytes_per_site_update"] = result.cost->bytes / result.site_updates;
    row["operations_per_site_update"] = result.cost->operations / result.site_updates;
    row["gigabytes_per_second"] = result.cost->bytes / seconds * giga;
    row["gigaoperations_per_second"] = result.cost->operations / seconds * giga;
  }
  if (result.share) {
    row["percent_of_ceiling"] = result.share->percent;
    row["binding"] = binding_names.at(static_cast<std::size_t>(result.share->binding));
  }
  if (result.ceilings) {
    const Ceilings& most = *result.ceilings;
    row["ceiling"] = {{"copy_gigabytes_per_second", median(most.copy_bytes_per_second) * giga},
                      {"gigaoperations_per_second", median(most.operations_per_second) * giga},
                      {"copy_samples", in_giga(most.copy_bytes_per_second)},
                      {"operation_samples", in_giga(most.operations_per_second)}};
  }
}

} // namespace

double msites_per_second(const BenchResult& result) {
  const double seconds = median_seconds(result.samples, &Timings::compute);
  return seconds > 0.0 ? result.site_updates / seconds * 1e-6 : 0.0;
}

std::string bench_method_name(const Scene& scene, const BenchResult& result) {
  return method_name(scene) + (result.work == Work::active ? "-active" : "");
}

json bench_row(const Scene& scene, const BenchResult& result) {
  const auto part = [&](auto which) { return median_seconds(result.samples, which); };
  const bool was_compared = !result.reference.empty();
  json row{{"scene", scene.name},
           {"width", scene.extent().width},
           {"height", scene.extent().height},
           {"backend", result.backend},
           {"device", result.device.name},
           {"driver", result.device.driver},
           {"method", bench_method_name(scene, result)},
           {"work", work_names.at(static_cast<std::size_t>(result.work))},
           {"threads", result.threads > 0 ? json(result.threads) : json()},
           {"effort", scene.schedule.iterations},
           {"iterations", result.iterations},
           {"fine_sweep_equivalents", result.site_updates / static_cast<double>(scene.extent().sites())},
           {"seconds", json::array()},
           {"seconds_median", part(&Timings::total)},
           {"msites_per_second", msites_per_second(result)},
           {"setup_seconds", result.setup_seconds},
           {"projection_seconds", part(&Timings::projection)},
           {"upload_seconds", part(&Timings::upload)},
           {"compute_seconds", part(&Timings::compute)},
           {"readback_seconds", part(&Timings::readback)},
           {"reference", was_compared ? json(result.reference) : json()},
           {"speed_up_over_scalar", result.reference == "scalar" ? json(result.speed_up) : json()},
           {"speed_up_over_dense", result.speed_up_over_dense},
           {"valid", was_compared || result.samples.empty() ? json(result.valid) : json()},
           {"reason", result.reason},
           {"peak_memory_bytes", result.peak_memory_bytes},
           {"bytes_per_site", result.bytes_per_site},
           {"choices", json::array()}};
  for (const Timings& sample : result.samples) {
    row["seconds"].push_back(sample.total());
  }
  for (const Choice& choice : result.choices) {
    row["choices"].push_back(to_json_row(choice));
  }
  add_cost(result, row);
  return row;
}

} // namespace hdmbench
