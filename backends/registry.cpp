#include "backends/registry.hpp"

#include "backends/cpu/cpu.hpp"
#include "backends/shared/driver_trial.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>

#ifdef HDMBENCH_WITH_EGL
#include "backends/gl/compute.hpp"
#endif
#if defined(HDMBENCH_WITH_EGL) || defined(HDMBENCH_WITH_OSMESA)
#include "backends/gl/fragment.hpp"
#endif
#ifdef HDMBENCH_WITH_CUDA
#include "backends/cuda/cuda.hpp"
#endif
#ifdef HDMBENCH_WITH_OPENCL
#include "backends/opencl/opencl.hpp"
#endif
#ifdef HDMBENCH_WITH_VULKAN
#include "backends/vulkan/vulkan_compute.hpp"
#endif

namespace hdmbench {

namespace {

/// Stands in for a backend that this build has left out.
class NotBuilt final : public Backend {
public:
  NotBuilt(std::string_view name, std::string_view option) : name_(name), option_(option) {}
  std::string_view name() const override { return name_; }
  std::string_view description() const override { return "not part of this build"; }
  std::vector<Device> devices() const override {
    throw DeviceError(fmt::format("this build was configured without {} (-D{}=ON)", option_, option_));
  }

private:
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& /*options*/) const override {
    throw DeviceError(fmt::format("{} is not part of this build", name_));
  }

  std::string_view name_;
  std::string_view option_;
};

} // namespace

std::vector<std::unique_ptr<Backend>> make_backends() {
  std::vector<std::unique_ptr<Backend>> backends;
  [[maybe_unused]] const auto add_not_built = [&](std::string_view name, std::string_view option) {
    backends.push_back(std::make_unique<NotBuilt>(name, option));
  };
  backends.push_back(make_scalar());
  backends.push_back(make_openmp());
#ifdef HDMBENCH_WITH_EGL
  backends.push_back(gl::make_fragment("gl-fragment",
                                       "GLSL 1.20 fragment shader, OpenGL through EGL: the thesis's design",
                                       gl::make_egl_platform()));
#else
  add_not_built("gl-fragment", "HDMBENCH_EGL");
#endif
#ifdef HDMBENCH_WITH_OSMESA
  backends.push_back(gl::make_fragment("gl-fragment-osmesa", "the same shader, OpenGL through OSMesa",
                                       gl::make_osmesa_platform()));
#else
  add_not_built("gl-fragment-osmesa", "HDMBENCH_OSMESA");
#endif
#ifdef HDMBENCH_WITH_EGL
  backends.push_back(gl::make_compute(gl::make_egl_platform()));
#else
  add_not_built("gl-compute", "HDMBENCH_EGL");
#endif
#ifdef HDMBENCH_WITH_VULKAN
  backends.push_back(make_vulkan_compute());
#else
  add_not_built("vulkan-compute", "HDMBENCH_VULKAN");
#endif
#ifdef HDMBENCH_WITH_OPENCL
  backends.push_back(make_opencl());
#else
  add_not_built("opencl", "HDMBENCH_OPENCL");
#endif
#ifdef HDMBENCH_WITH_CUDA
  backends.push_back(make_cuda());
#else
  add_not_built("cuda", "HDMBENCH_CUDA");
#endif
  return backends;
}

const Backend& find_backend(const std::vector<std::unique_ptr<Backend>>& backends, std::string_view name) {
  const auto found =
      std::ranges::find_if(backends, [&](const auto& backend) { return backend->name() == name; });
  if (found == backends.end()) {
    std::string names;
    for (const auto& backend : backends) {
      names += fmt::format("{}{}", names.empty() ? "" : ", ", backend->name());
    }
    throw InputError(fmt::format("there is no backend \"{}\"; the backends are {}", name, names));
  }
  return **found;
}

void ask_drivers_apart(int argc, const char* const* argv) {
  begin_driver_trials(argc, argv, [](std::string_view backend) {
    const auto backends = make_backends();
    try {
      (void)find_backend(backends, backend).devices();
    } catch (const DeviceError&) { // is an answer, too: the one who asks will get it again
    }
  });
}

} // namespace hdmbench
