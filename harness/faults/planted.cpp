#include "harness/faults/planted.hpp"

#include "harness/faults/fused_backend.hpp"
#include "harness/faults/session_faults.hpp"

#ifdef HDMBENCH_WITH_GL
#include "backends/gl/compute.hpp"
#include "backends/gl/fragment.hpp"
#include "harness/faults/device_faults.hpp"
#endif

#include <fmt/format.h>

#include <utility>

namespace hdmbench::faults {

namespace {

Planted in_session(const Backend& carrier, const Fault& fault, Expected expected = Expected::disagree) {
  return {.name = fault.name,
          .what = fault.what,
          .backend = std::string(carrier.name()),
          .layer = Layer::session,
          .expected = expected,
          .method = fault.method,
          .make = [&carrier, fault](const Scene& scene) {
            return std::make_unique<FaultyBackend>(carrier, fault, &scene);
          }};
}

std::vector<Planted> session_controls(const Backend& carrier) {
  const auto control = [&](const Fault& fault) { return in_session(carrier, fault, Expected::let_through); };
  return {control({.name = "sound", .what = "no mistake", .method = ""}),
          control({.name = "negative-zero",
                   .what = "-0 where 0 belongs, which it equals",
                   .method = "",
                   .in_read =
                       [](VectorField& field) {
                         for (auto* const values : {&field.x, &field.y}) {
                           for (float& value : *values) {
                             value = value == 0.0F ? -0.0F : value;
                           }
                         }
                       }}),
          {.name = "fused",
           .what = "fused multiply-adds wherever there can be one",
           .backend = "fused C++",
           .layer = Layer::session,
           .expected = Expected::let_through,
           .method = "",
           .make = [](const Scene&) { return make_fused(); }}};
}

#ifdef HDMBENCH_WITH_GL

/// Where a pipeline of this build runs.
struct Carrier {
  std::string backend;
  Pipeline pipeline;
  std::unique_ptr<gl::Platform> (*platform)();

  [[nodiscard]] std::unique_ptr<Backend> make(std::unique_ptr<gl::Platform> on) const {
#ifdef HDMBENCH_WITH_EGL
    if (pipeline == Pipeline::compute) {
      return gl::make_compute(std::move(on));
    }
#endif
    return gl::make_fragment(backend, "", std::move(on));
  }
  [[nodiscard]] bool is_there() const {
    try {
      return !make(platform())->devices().empty();
    } catch (const DeviceError&) {
      return false;
    }
  }
};

std::vector<Carrier> carriers() {
  std::vector<Carrier> list;
#ifdef HDMBENCH_WITH_EGL
  list.push_back({"gl-fragment", Pipeline::fragment, gl::make_egl_platform});
#endif
#ifdef HDMBENCH_WITH_OSMESA
  const Carrier osmesa{"gl-fragment-osmesa", Pipeline::fragment, gl::make_osmesa_platform};
  if (list.empty()) {
    list.push_back(osmesa);
  } else if (!list.front().is_there() && osmesa.is_there()) {
    list.front() = osmesa;
  }
#endif
#ifdef HDMBENCH_WITH_EGL
  list.push_back({"gl-compute", Pipeline::compute, gl::make_egl_platform});
#endif
  return list;
}

Planted in_device(const Carrier& carrier, const DeviceFault& fault) {
  const auto record = std::make_shared<PlantingRecord>();
  const auto require_planted = [record, edits = fault.edits.size(), calls = fault.calls.size()] {
    if (record->edits < static_cast<int>(edits)) {
      throw NotPlanted("no shader that was meant has gone to the driver");
    }
    if (calls > 0 && record->calls == 0) {
      throw NotPlanted("the call has never been made");
    }
  };
  return {.name = fault.name,
          .what = fault.what,
          .backend = carrier.backend,
          .layer = fault.edits.empty() ? Layer::driver : Layer::shader,
          .expected = fault.expected,
          .method = fault.method,
          .make =
              [carrier, fault, record](const Scene&) {
                *record = {};
                return carrier.make(make_faulty_platform(carrier.platform(), fault, record));
              },
          .require_planted = require_planted};
}

/// On both pipelines: `faults` of each.
void add_in_devices(std::vector<Planted>& list, std::vector<DeviceFault> (*faults)(Pipeline)) {
  for (const Carrier& carrier : carriers()) {
    for (const DeviceFault& fault : faults(carrier.pipeline)) {
      list.push_back(in_device(carrier, fault));
    }
  }
}

#endif

} // namespace

std::vector<Planted> all_planted(const Backend& carrier) {
  std::vector<Planted> list = session_controls(carrier);
#ifdef HDMBENCH_WITH_GL
  add_in_devices(list, device_controls);
#endif
  for (const Fault& fault : session_faults()) {
    const bool possible = fault.name != "in-place" || carrier.supports(Update::sequential);
    if (possible) {
      list.push_back(in_session(carrier, fault));
    }
  }
#ifdef HDMBENCH_WITH_GL
  add_in_devices(list, text_faults);
  add_in_devices(list, call_faults);
#endif
  return list;
}

} // namespace hdmbench::faults
