#include "backends/gl/context.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

namespace hdmbench::gl {

namespace {

std::string text(const Api& api, GLenum name) {
  const GLubyte* found = api.GetString(name);
  return found == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(found));
}

bool is_software(std::string_view renderer) {
  constexpr std::array<std::string_view, 4> rasterizers{"llvmpipe", "softpipe", "swrast", "SWR"};
  return std::ranges::any_of(
      rasterizers, [&](std::string_view name) { return renderer.find(name) != std::string_view::npos; });
}

} // namespace

void throw_pending_error(const char* name, GLenum (*get_error)()) {
  static constexpr std::array names{"GL_INVALID_ENUM",
                                    "GL_INVALID_VALUE",
                                    "GL_INVALID_OPERATION",
                                    "GL_STACK_OVERFLOW",
                                    "GL_STACK_UNDERFLOW",
                                    "GL_OUT_OF_MEMORY",
                                    "GL_INVALID_FRAMEBUFFER_OPERATION",
                                    "GL_CONTEXT_LOST"};
  const GLenum error = get_error();
  if (error != GL_NO_ERROR) {
    const GLenum number = error - GL_INVALID_ENUM;
    throw DeviceError(fmt::format("{}: {} (0x{:04x})", name,
                                  number < names.size() ? names.at(number) : "unknown OpenGL error", error));
  }
}

void throw_missing(const char* name) {
  throw DeviceError(fmt::format("the OpenGL driver has no {}", name));
}

void throw_made_nothing(const char* name) {
  throw DeviceError(fmt::format("{} made nothing, and gave no error", name));
}

/// "4.5 (Compatibility Profile) Mesa 22.3.6": GL_MAJOR_VERSION does not exist in OpenGL 2.1.
Version version_of(const Api& api) {
  const std::string version = text(api, GL_VERSION);
  Version parsed;
  const auto dot = version.find('.');
  if (dot != std::string::npos) {
    std::from_chars(version.data(), version.data() + dot, parsed.major);
    std::from_chars(version.data() + dot + 1, version.data() + version.size(), parsed.minor);
  }
  return parsed;
}

Device describe(Context& context, Version version) {
  const Context::Current current(context);
  const std::string renderer = text(context.api(), GL_RENDERER);
  const std::string found = text(context.api(), GL_VERSION);
  const Version parsed = version_of(context.api());
  if (parsed < version) {
    throw DeviceError(
        fmt::format("{} offers OpenGL {}, {}.{} is needed", renderer, found, version.major, version.minor));
  }
  if (parsed.major < 3) { // later they are a part of OpenGL
    const std::string extensions = fmt::format(" {} ", text(context.api(), GL_EXTENSIONS));
    for (const char* const needed :
         {"GL_ARB_texture_float", "GL_ARB_texture_rectangle", "GL_EXT_framebuffer_object"}) {
      if (extensions.find(fmt::format(" {} ", needed)) == std::string::npos) {
        throw DeviceError(fmt::format("{}, OpenGL {}, has no {}, which is needed", renderer, found, needed));
      }
    }
  }
  return {.name = renderer,
          .driver = "OpenGL " + found,
          .is_software = counts_as_software(is_software(renderer))};
}

} // namespace hdmbench::gl
