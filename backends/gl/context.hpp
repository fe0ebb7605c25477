#pragma once

#include "backends/gl/api.hpp"
#include "backends/shared/interface.hpp"

#include <compare>
#include <memory>
#include <string>
#include <vector>

namespace hdmbench::gl {

/// The version of OpenGL.
struct Version {
  int major = 0;
  int minor = 0;

  auto operator<=>(const Version&) const = default;
};

/// Returns the version of the current context. Throws nothing.
[[nodiscard]] Version version_of(const Api& api);

/// An OpenGL context without a window. It is current only while a Current lives: EGL's and OSMesa's libraries
/// may share the thread's dispatch table, so a context of one must not stay behind while the other works.
class Context : public Interface {
public:
  class Current {
  public:
    explicit Current(Context& context) : context_(context) { context_.bind(); }
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;
    ~Current() { context_.unbind(); }

  private:
    Context& context_;
  };
  using Use = Current; ///< OnDevice

  /// Only while current.
  [[nodiscard]] virtual const Api& api() const = 0;
  /// Waits, without an error: OSMesa does not wait for drawing when a context goes.
  void settle() noexcept { api().quietly(api().Finish); }
  /// It cannot be made current any more: what destroys its objects calls nothing from now on.
  virtual void abandon() noexcept = 0;

private:
  virtual void bind() = 0;
  virtual void unbind() noexcept = 0;
};

/// Where contexts come from: EGL or OSMesa.
class Platform : public Interface {
public:
  /// Everything that offers `version`. Throws DeviceError with the reason where nothing does.
  [[nodiscard]] virtual std::vector<Device> devices(Version version) const = 0;
  /// `index` into devices(version). Throws DeviceError.
  [[nodiscard]] virtual std::unique_ptr<Context> open(std::size_t index, Version version) const = 0;
};

[[nodiscard]] std::unique_ptr<Platform> make_egl_platform();
[[nodiscard]] std::unique_ptr<Platform> make_osmesa_platform();

/// GL_RENDERER and GL_VERSION of a context; throws DeviceError if the context is older than `version`.
[[nodiscard]] Device describe(Context& context, Version version);

} // namespace hdmbench::gl
