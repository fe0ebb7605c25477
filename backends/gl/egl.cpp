#include "backends/gl/context.hpp"
#include "backends/shared/library.hpp"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace hdmbench::gl {

namespace {

const char* error_name(EGLint error) {
  static constexpr std::array names{"EGL_SUCCESS",       "EGL_NOT_INITIALIZED",     "EGL_BAD_ACCESS",
                                    "EGL_BAD_ALLOC",     "EGL_BAD_ATTRIBUTE",       "EGL_BAD_CONFIG",
                                    "EGL_BAD_CONTEXT",   "EGL_BAD_CURRENT_SURFACE", "EGL_BAD_DISPLAY",
                                    "EGL_BAD_MATCH",     "EGL_BAD_NATIVE_PIXMAP",   "EGL_BAD_NATIVE_WINDOW",
                                    "EGL_BAD_PARAMETER", "EGL_BAD_SURFACE",         "EGL_CONTEXT_LOST"};
  const auto number = static_cast<std::size_t>(error - EGL_SUCCESS);
  return number < names.size() ? names.at(number) : "unknown EGL error";
}

bool has_word(std::string_view all, std::string_view word) {
  return fmt::format(" {} ", all).find(fmt::format(" {} ", word)) != std::string::npos;
}

struct Egl {
  Library library{"libEGL.so.1"};

#define HDMBENCH_EGL(name) decltype(&::name) name = library.function<decltype(&::name)>(#name)
  HDMBENCH_EGL(eglBindAPI);
  HDMBENCH_EGL(eglChooseConfig);
  HDMBENCH_EGL(eglCreateContext);
  HDMBENCH_EGL(eglDestroyContext);
  HDMBENCH_EGL(eglGetError);
  HDMBENCH_EGL(eglGetProcAddress);
  HDMBENCH_EGL(eglInitialize);
  HDMBENCH_EGL(eglMakeCurrent);
  HDMBENCH_EGL(eglQueryString);
#undef HDMBENCH_EGL

  [[noreturn]] void fail(const char* call) const {
    throw DeviceError(fmt::format("{}: {}", call, error_name(eglGetError())));
  }

  /// Of a display, or of the library where it is EGL_NO_DISPLAY.
  [[nodiscard]] const char* extensions(EGLDisplay display) const {
    const char* found = eglQueryString(display, EGL_EXTENSIONS);
    if (found == nullptr) {
      fail(display == EGL_NO_DISPLAY ? "eglQueryString of EGL_NO_DISPLAY" : "eglQueryString");
    }
    return found;
  }

  void bind_opengl() const {
    if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) {
      fail("eglBindAPI(EGL_OPENGL_API)");
    }
  }

  /// A function of an extension that is there.
  template <typename Function>
  [[nodiscard]] Function extension_function(const char* name) const {
    const auto found = reinterpret_cast<Function>(eglGetProcAddress(name));
    if (found == nullptr) {
      throw DeviceError(fmt::format("libEGL.so.1 has no {}", name));
    }
    return found;
  }
};

/// What a display is asked of.
struct NativeDevice {
  EGLenum platform;
  void* native;
};

/// An initialised display. Displays belong to the process and eglTerminate would take every other session's
/// contexts along, so they are left to the end of the process.
EGLDisplay initialise(const Egl& egl, const NativeDevice& device) {
  const auto get_display =
      egl.extension_function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  EGLDisplay display = get_display(device.platform, device.native, nullptr);
  if (display == EGL_NO_DISPLAY) {
    egl.fail("eglGetPlatformDisplayEXT");
  }
  if (egl.eglInitialize(display, nullptr, nullptr) == EGL_FALSE) {
    egl.fail("eglInitialize");
  }
  if (!has_word(egl.extensions(display), "EGL_KHR_surfaceless_context")) {
    throw DeviceError("the EGL display has no EGL_KHR_surfaceless_context");
  }
  return display;
}

class EglContext final : public Context {
public:
  EglContext(std::shared_ptr<const Egl> egl, const NativeDevice& device, Version version)
      : egl_(std::move(egl)), display_(initialise(*egl_, device)), context_(create(version)),
        api_([this](const char* name) { return egl_->eglGetProcAddress(name); }) {}

  ~EglContext() override { egl_->eglDestroyContext(display_, context_); }

  const Api& api() const override { return api_; }
  void abandon() noexcept override { api_.abandoned = true; }

private:
  [[nodiscard]] EGLContext create(Version version) const {
    egl_->bind_opengl();
    const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                       EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (egl_->eglChooseConfig(display_, wanted.data(), &config, 1, &count) == EGL_FALSE) {
      egl_->fail("eglChooseConfig");
    }
    if (count == 0) {
      throw DeviceError("eglChooseConfig: no configuration for desktop OpenGL");
    }
    const std::array<EGLint, 5> attributes{EGL_CONTEXT_MAJOR_VERSION, version.major,
                                           EGL_CONTEXT_MINOR_VERSION, version.minor, EGL_NONE};
    EGLContext context = egl_->eglCreateContext(display_, config, EGL_NO_CONTEXT, attributes.data());
    if (context == EGL_NO_CONTEXT) {
      egl_->fail(fmt::format("eglCreateContext (OpenGL {}.{})", version.major, version.minor).c_str());
    }
    return context;
  }

  void bind() override {
    egl_->bind_opengl();
    if (egl_->eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
      egl_->fail("eglMakeCurrent");
    }
  }

  void unbind() noexcept override {
    egl_->eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }

  std::shared_ptr<const Egl> egl_;
  EGLDisplay display_;
  EGLContext context_;
  Api api_;
};

/// Every EGL device by EGL_EXT_platform_device, and Mesa's surfaceless platform where devices cannot be
/// listed.
std::vector<NativeDevice> native_devices(const Egl& egl) {
  const std::string_view extensions = egl.extensions(EGL_NO_DISPLAY);
  std::vector<NativeDevice> found;
  if (has_word(extensions, "EGL_EXT_platform_device") && has_word(extensions, "EGL_EXT_device_enumeration")) {
    const auto query_devices = egl.extension_function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    EGLint count = 0;
    if (query_devices(0, nullptr, &count) == EGL_FALSE) {
      egl.fail("eglQueryDevicesEXT");
    }
    std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
    if (query_devices(count, devices.data(), &count) == EGL_FALSE) {
      egl.fail("eglQueryDevicesEXT");
    }
    devices.resize(std::min(devices.size(), static_cast<std::size_t>(count)));
    for (EGLDeviceEXT device : devices) {
      found.push_back({EGL_PLATFORM_DEVICE_EXT, device});
    }
  }
  if (found.empty() && has_word(extensions, "EGL_MESA_platform_surfaceless")) {
    found.push_back({EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY});
  }
  return found;
}

class EglPlatform final : public Platform {
public:
  std::vector<Device> devices(Version version) const override {
    std::vector<Device> found;
    for (const Candidate& candidate : candidates(version)) {
      found.push_back(candidate.device);
    }
    return found;
  }

  std::unique_ptr<Context> open(std::size_t index, Version version) const override {
    std::vector<Candidate> found = candidates(version);
    if (index >= found.size()) {
      throw DeviceError(fmt::format("EGL device {} has gone, {} are left", index, found.size()));
    }
    return std::move(found[index].context);
  }

private:
  struct Candidate {
    Device device;
    std::unique_ptr<Context> context;
  };

  /// A device can be named only by asking a context on it.
  static std::vector<Candidate> candidates(Version version) {
    const auto egl = std::make_shared<const Egl>();
    std::vector<Candidate> found;
    std::string reasons;
    for (const NativeDevice& native : native_devices(*egl)) {
      try {
        auto context = std::make_unique<EglContext>(egl, native, version);
        Device device = describe(*context, version);
        found.push_back({std::move(device), std::move(context)});
      } catch (const DeviceError& error) {
        reasons += fmt::format("{}{}", reasons.empty() ? "" : "; ", error.what());
      }
    }
    if (found.empty()) {
      throw DeviceError(reasons.empty() ? "EGL has no device and no surfaceless platform" : reasons);
    }
    return found;
  }
};

} // namespace

std::unique_ptr<Platform> make_egl_platform() {
  return std::make_unique<EglPlatform>();
}

} // namespace hdmbench::gl
