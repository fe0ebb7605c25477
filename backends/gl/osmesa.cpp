#include "backends/gl/context.hpp"
#include "backends/shared/library.hpp"

#include <GL/osmesa.h>
#include <fmt/format.h>

#include <array>

namespace hdmbench::gl {

namespace {

struct OsMesa {
  Library library = open();

#define HDMBENCH_OSMESA(name) decltype(&::name) name = library.function<decltype(&::name)>(#name)
  HDMBENCH_OSMESA(OSMesaCreateContextAttribs);
  HDMBENCH_OSMESA(OSMesaDestroyContext);
  HDMBENCH_OSMESA(OSMesaGetProcAddress);
  HDMBENCH_OSMESA(OSMesaMakeCurrent);
#undef HDMBENCH_OSMESA

  static Library open() {
    try {
      return Library("libOSMesa.so.8");
    } catch (const DeviceError& error) {
      throw DeviceError(fmt::format("{} (Mesa 25.1 and later no longer has OSMesa)", error.what()));
    }
  }
};

class OsMesaContext final : public Context {
public:
  explicit OsMesaContext(Version version)
      : context_(create(version)),
        api_([this](const char* name) { return mesa_.OSMesaGetProcAddress(name); }) {}

  ~OsMesaContext() override { mesa_.OSMesaDestroyContext(context_); }

  const Api& api() const override { return api_; }
  void abandon() noexcept override { api_.abandoned = true; }

private:
  [[nodiscard]] OSMesaContext create(Version version) const {
    const std::array<int, 9> attributes{OSMESA_FORMAT,
                                        OSMESA_RGBA,
                                        OSMESA_PROFILE,
                                        OSMESA_COMPAT_PROFILE,
                                        OSMESA_CONTEXT_MAJOR_VERSION,
                                        version.major,
                                        OSMESA_CONTEXT_MINOR_VERSION,
                                        version.minor,
                                        0};
    OSMesaContext context = mesa_.OSMesaCreateContextAttribs(attributes.data(), nullptr);
    if (context == nullptr) {
      throw DeviceError(
          fmt::format("OSMesaCreateContextAttribs (OpenGL {}.{}) failed", version.major, version.minor));
    }
    return context;
  }

  void bind() override {
    if (mesa_.OSMesaMakeCurrent(context_, framebuffer_.data(), GL_UNSIGNED_BYTE, 1, 1) == GL_FALSE) {
      throw DeviceError("OSMesaMakeCurrent failed");
    }
  }

  void unbind() noexcept override { mesa_.OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }

  OsMesa mesa_;
  std::array<unsigned char, 4> framebuffer_{}; ///< OSMesa insists on one; we draw into framebuffer objects
  OSMesaContext context_;
  Api api_;
};

class OsMesaPlatform final : public Platform {
public:
  std::vector<Device> devices(Version version) const override {
    OsMesaContext context(version);
    return {describe(context, version)};
  }

  std::unique_ptr<Context> open(std::size_t /*index*/, Version version) const override {
    return std::make_unique<OsMesaContext>(version);
  }
};

} // namespace

std::unique_ptr<Platform> make_osmesa_platform() {
  return std::make_unique<OsMesaPlatform>();
}

} // namespace hdmbench::gl
