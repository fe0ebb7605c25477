#include "backends/gl/api.hpp"

#include <fmt/format.h>

namespace hdmbench::gl {

namespace {

const char* error_name(GLenum error) {
  switch (error) {
  case GL_INVALID_ENUM:
    return "GL_INVALID_ENUM";
  case GL_INVALID_VALUE:
    return "GL_INVALID_VALUE";
  case GL_INVALID_OPERATION:
    return "GL_INVALID_OPERATION";
  case GL_INVALID_FRAMEBUFFER_OPERATION:
    return "GL_INVALID_FRAMEBUFFER_OPERATION";
  case GL_OUT_OF_MEMORY:
    return "GL_OUT_OF_MEMORY";
  case GL_CONTEXT_LOST:
    return "GL_CONTEXT_LOST";
  default:
    return "unknown OpenGL error";
  }
}

} // namespace

void throw_pending_error(const char* name, GLenum (*get_error)()) {
  const GLenum error = get_error();
  if (error != GL_NO_ERROR) {
    throw DeviceError(fmt::format("{}: {} (0x{:04x})", name, error_name(error), error));
  }
}

void throw_missing(const char* name) {
  throw DeviceError(fmt::format("the OpenGL driver has no {}", name));
}

void throw_made_nothing(const char* name) {
  throw DeviceError(fmt::format("{} made nothing, and gave no error", name));
}

} // namespace hdmbench::gl
