#include "harness/measure/bench_row.hpp"

#include "harness/measure/choices.hpp"
#include "harness/measure/median.hpp"
#include "harness/scene/row_fields.hpp"

#include <algorithm>
#include <iterator>

namespace hdmbench {

namespace {

std::vector<double> in_giga(const std::vector<double>& rates) {
  std::vector<double> values;
  std::ranges::transform(rates, std::back_inserter(values), [](double rate) { return rate * 1e-9; });
  return values;
}

/// Of a solution's cost: per site update, and per second of compute.
void add_cost(const BenchResult& result, BenchRow& row) {
  if (result.cost && result.site_updates > 0.0 && row.compute_seconds > 0.0) {
    row.bytes_per_site_update = result.cost->bytes / result.site_updates;
    row.operations_per_site_update = result.cost->operations / result.site_updates;
    row.gigabytes_per_second = result.cost->bytes / *row.compute_seconds * 1e-9;
    row.gigaoperations_per_second = result.cost->operations / *row.compute_seconds * 1e-9;
  }
  if (result.share) {
    row.percent_of_ceiling = result.share->percent;
    row.binding = result.share->binding;
  }
  if (result.ceilings) {
    row.ceiling = {.copy_gigabytes_per_second = median(result.ceilings->copy_bytes_per_second) * 1e-9,
                   .gigaoperations_per_second = median(result.ceilings->operations_per_second) * 1e-9,
                   .copy_samples = in_giga(result.ceilings->copy_bytes_per_second),
                   .operation_samples = in_giga(result.ceilings->operations_per_second)};
  }
}

} // namespace

static void list_fields(Fields& fields, BenchRow::Ceiling& ceiling) {
  fields.newer("copy_gigabytes_per_second", ceiling.copy_gigabytes_per_second);
  fields.newer("gigaoperations_per_second", ceiling.gigaoperations_per_second);
  fields.newer("copy_samples", ceiling.copy_samples);
  fields.newer("operation_samples", ceiling.operation_samples);
}

void list_fields(Fields& fields, BenchRow& row) {
  fields("scene", row.scene);
  fields("width", row.width);
  fields("height", row.height);
  fields("backend", row.backend);
  fields("device", row.device);
  fields.newer("driver", row.driver);
  fields("method", row.method);
  fields.newer("work", row.work);
  fields.newer("threads", row.threads);
  fields.newer("effort", row.effort);
  fields("iterations", row.iterations);
  fields.newer("fine_sweep_equivalents", row.fine_sweep_equivalents);
  fields("seconds", row.seconds);
  fields("seconds_median", row.seconds_median);
  fields("msites_per_second", row.msites_per_second);
  fields("setup_seconds", row.setup_seconds);
  fields("projection_seconds", row.projection_seconds);
  fields("upload_seconds", row.upload_seconds);
  fields("compute_seconds", row.compute_seconds);
  fields("readback_seconds", row.readback_seconds);
  fields.newer("reference", row.reference);
  fields("speed_up_over_scalar", row.speed_up_over_scalar);
  fields.newer("speed_up_over_dense", row.speed_up_over_dense);
  fields("valid", row.valid);
  fields("reason", row.reason);
  fields.newer("peak_memory_bytes", row.peak_memory_bytes);
  fields.newer("bytes_per_site", row.bytes_per_site);
  fields.newer("choices", row.choices);
  fields.newer("bytes_per_site_update", row.bytes_per_site_update);
  fields.newer("operations_per_site_update", row.operations_per_site_update);
  fields.newer("gigabytes_per_second", row.gigabytes_per_second);
  fields.newer("gigaoperations_per_second", row.gigaoperations_per_second);
  fields.newer("percent_of_ceiling", row.percent_of_ceiling);
  fields.newer("binding", row.binding);
  fields.newer("ceiling", row.ceiling);
  if (fields.reading() && !row.valid.value_or(false)) {
    row.speed_up_over_scalar.reset();
  }
  if (fields.reading() && !row.counts()) {
    row.speed_up_over_dense.reset();
  }
}

void require_consistent(const BenchRow& row) {
  if (!row.counts()) {
    return;
  }
  refuse_if(row.width == 0 || row.height == 0, "width", "and \"height\" of a valid row must be at least 1");
  require_samples(row.seconds, row.seconds_median);
}

double msites_per_second(const BenchResult& result) {
  const double seconds = median_seconds(result.samples, &Timings::compute);
  return seconds > 0.0 ? result.site_updates / seconds * 1e-6 : 0.0;
}

std::string bench_method_name(const Scene& scene, const BenchResult& result) {
  return method_name(scene) + (result.work == Work::active ? "-active" : "");
}

BenchRow bench_row(const Scene& scene, const BenchResult& result) {
  const auto part = [&](auto which) { return median_seconds(result.samples, which); };
  BenchRow row{
      .scene = scene.name,
      .width = scene.extent().width,
      .height = scene.extent().height,
      .backend = result.backend,
      .device = result.device.name,
      .driver = result.device.driver,
      .method = bench_method_name(scene, result),
      .work = result.work,
      .effort = scene.schedule.iterations,
      .iterations = result.iterations,
      .fine_sweep_equivalents = result.site_updates / static_cast<double>(scene.extent().sites()),
      .seconds = {},
      .seconds_median = part(&Timings::total),
      .msites_per_second = msites_per_second(result),
      .setup_seconds = result.setup_seconds,
      .projection_seconds = part(&Timings::projection),
      .upload_seconds = part(&Timings::upload),
      .compute_seconds = part(&Timings::compute),
      .readback_seconds = part(&Timings::readback),
      .speed_up_over_dense = result.speed_up_over_dense,
      .reason = result.reason,
      .peak_memory_bytes = result.peak_memory_bytes,
      .bytes_per_site = result.bytes_per_site,
      .choices = result.choices,
  };
  std::ranges::transform(result.samples, std::back_inserter(row.seconds), &Timings::total);
  if (result.threads > 0) {
    row.threads = result.threads;
  }
  if (!result.reference.empty()) {
    row.reference = result.reference;
  }
  if (result.reference == "scalar") {
    row.speed_up_over_scalar = result.speed_up;
  }
  if (!result.reference.empty() || result.samples.empty()) {
    row.valid = result.valid;
  }
  add_cost(result, row);
  return row;
}

} // namespace hdmbench
