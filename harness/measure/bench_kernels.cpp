#include "backends/shared/stopwatch.hpp"
#include "harness/measure/bench_case.hpp"
#include "harness/measure/kernels.hpp"
#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace hdmbench {

using nlohmann::json;

namespace {

constexpr int together = 8; ///< that are waited for at once

json new_kernel_row(const TimedKernel& kernel, const Backend& backend, const SessionOptions& session,
                    Extent image, std::string_view energy) {
  const int threads = backend.threads(session);
  json row = with_size({{"kernel", kernel.name},
                        {"level", kernel.level},
                        {"energy", energy},
                        {"backend", backend.name()},
                        {"device", ""},
                        {"driver", ""},
                        {"threads", threads > 0 ? json(threads) : json()},
                        {"sites", kernel.sites.sites()},
                        {"seconds", json::array()},
                        {"valid", nullptr},
                        {"reason", ""}},
                       image);
  for (const char* const key :
       {"reference", "seconds_median", "alone_seconds", "device_seconds", "launch_seconds",
        "processor_seconds", "spread_percent", "msites_per_second", "bytes_per_site", "operations_per_site",
        "gigabytes_per_second", "gigaoperations_per_second", "percent_of_ceiling", "binding", "ceiling"}) {
    row[key] = nullptr;
  }
  if (kernel.cost.bytes > 0.0) {
    row.update({{"bytes_per_site", kernel.cost.bytes}, {"operations_per_site", kernel.cost.operations}});
  }
  return row;
}

} // namespace

void Bench::add_kernels(const KernelPlan& plan) {
  for (const Backend* const backend : plan.options.backends) {
    const std::string_view energy = plan.elastic ? "elastic" : "hdm";
    const std::size_t place = places_.size();
    places_.push_back({.load = {}, .options = plan.options, .name = std::string(energy)});
    const auto kernels = std::make_shared<Kernels>(*backend, plan.options.session, plan.elastic, plan.extent);
    for (std::size_t i = 0; i < kernels->all().size(); ++i) {
      const TimedKernel& kernel = kernels->all()[i];
      json row = new_kernel_row(kernel, *backend, plan.options.session, plan.extent, energy);
      std::string name = fmt::format("kernel/{}/{}/level {}/{}/{}", energy, plan.extent.text("x"),
                                     kernel.level, kernel.name, backend->name());
      const bool has_energy = !plan.elastic || backend->has_elastic();
      register_case({.name = std::move(name),
                     .place = place,
                     .backend = backend,
                     .session = plan.options.session,
                     .refusal = has_energy ? "" : "has no elastic energy",
                     .row = std::move(row),
                     .kernels = kernels,
                     .kernel = i});
    }
  }
}

void Bench::measure_kernel(Case& one, benchmark::State& state) {
  const TimedKernel& kernel = one.kernels->all()[one.kernel];
  if (open_ != one.kernels) {
    if (open_) {
      open_->close(); // before the next one needs the room
    }
    open_ = one.kernels;
  }
  const Device device = one.backend->device(one.session);
  one.row.update({{"device", device.name}, {"driver", device.driver}});
  progress_.describe(fmt::format("bench {}", one.name));
  if (!one.is_prepared) {
    set_ceilings(one);
    one.is_prepared = true;
  }
  one.kernels->prepare(one.kernel);
  one.kernels->run(one.kernel, 1); // what compiles does so now
  const int batch = kernel.is_on_host ? 1 : together;
  double alone = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 5; ++i) {
    const Clock clock;
    one.kernels->run(one.kernel, 1);
    alone = std::min(alone, clock.seconds());
  }
  one.row["alone_seconds"] = alone;
  (void)one.kernels->device_seconds(); // counts from now on
  double sum = 0.0;
  double device_sum = 0.0;
  while (state.KeepRunningBatch(batch)) {
    const Clock clock;
    one.kernels->run(one.kernel, batch);
    const double seconds = clock.seconds();
    state.SetIterationTime(seconds);
    sum += seconds;
    device_sum += one.kernels->device_seconds().value_or(0.0);
  }
  const double seconds = sum / static_cast<double>(state.iterations());
  if (device_sum > 0.0 && !kernel.is_on_host) {
    const double device_seconds = device_sum / static_cast<double>(state.iterations());
    state.counters["device_seconds"] = device_seconds;
    state.counters["launch_seconds"] = seconds - device_seconds;
  }
  const auto sites = static_cast<double>(kernel.sites.sites());
  state.SetLabel(fmt::format("{}, {}", device.name, device.driver));
  state.counters["site_updates_per_second"] = sites / seconds;
  if (kernel.cost.bytes > 0.0) {
    const double bytes = kernel.cost.bytes * sites;
    const double operations = kernel.cost.operations * sites;
    state.counters["bytes_per_second"] = bytes / seconds;
    state.counters["operations_per_second"] = operations / seconds;
    if (one.most) {
      const bool is_cached = bytes <= cache_bytes(*one.backend, device);
      const CeilingShare share =
          ceiling_share({operations, bytes, is_cached ? 0.0 : bytes}, *one.most, seconds);
      one.row["binding"] = share.binding;
      state.counters["percent_of_ceiling"] = share.percent;
    }
  }
}

} // namespace hdmbench
