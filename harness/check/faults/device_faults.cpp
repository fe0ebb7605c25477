#include "harness/check/faults/device_faults.hpp"

#include "backends/gl/fragment.hpp"

#ifdef HDMBENCH_WITH_EGL
#include "backends/gl/compute.hpp"
#endif

#include <memory>
#include <utility>

namespace hdmbench::faults {

namespace {

std::string backend_name(Pipeline pipeline) {
#ifdef HDMBENCH_WITH_EGL
  return pipeline == Pipeline::compute ? "gl-compute" : "gl-fragment";
#else
  (void)pipeline;
  return "gl-fragment-osmesa";
#endif
}

[[maybe_unused]] bool has_device(const gl::Platform& platform) {
  try {
    return !platform.devices({2, 1}).empty();
  } catch (const DeviceError&) {
    return false;
  }
}

/// EGL; OSMesa where only that has a device, or only that is built.
std::unique_ptr<gl::Platform> make_fragment_platform() {
#ifdef HDMBENCH_WITH_EGL
  auto egl = gl::make_egl_platform();
#ifdef HDMBENCH_WITH_OSMESA
  if (!has_device(*egl)) {
    auto osmesa = gl::make_osmesa_platform();
    return has_device(*osmesa) ? std::move(osmesa) : std::move(egl);
  }
#endif
  return egl;
#else
  return gl::make_osmesa_platform();
#endif
}

std::unique_ptr<Backend> make_backend(Pipeline pipeline, const DeviceFault& fault,
                                      const std::shared_ptr<PlantingRecord>& record) {
#ifdef HDMBENCH_WITH_EGL
  if (pipeline == Pipeline::compute) {
    return gl::make_compute(make_faulty_platform(gl::make_egl_platform(), fault, record));
  }
#endif
  return gl::make_fragment(backend_name(pipeline), "",
                           make_faulty_platform(make_fragment_platform(), fault, record));
}

} // namespace

std::vector<Pipeline> pipelines() {
#ifdef HDMBENCH_WITH_EGL
  return {Pipeline::fragment, Pipeline::compute};
#else
  return {Pipeline::fragment};
#endif
}

Planted plant(Pipeline pipeline, const DeviceFault& fault) {
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
          .backend = backend_name(pipeline),
          .layer = fault.edits.empty() ? Layer::driver : Layer::shader,
          .expected = fault.expected,
          .method = fault.method,
          .variant = fault.variant,
          .part = fault.part,
          .make =
              [pipeline, fault, record](const Scene&) {
                *record = {};
                return make_backend(pipeline, fault, record);
              },
          .require_planted = require_planted};
}

} // namespace hdmbench::faults
