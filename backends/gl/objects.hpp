#pragma once

#include "backends/gl/api.hpp"

#include <string>
#include <utility>

namespace hdmbench::gl {

/// Owns one OpenGL name that glDelete*s(1, &name) gives back. The context must be current in constructor and
/// destructor.
template <auto Generate, auto Delete>
class Object {
public:
  explicit Object(const Api& api) : api_(&api) { (api.*Generate)(1, &name_); }
  Object(Object&& other) noexcept : api_(other.api_), name_(std::exchange(other.name_, 0)) {}
  Object& operator=(Object&& other) noexcept {
    std::swap(api_, other.api_);
    std::swap(name_, other.name_);
    return *this;
  }
  Object(const Object&) = delete;
  Object& operator=(const Object&) = delete;
  ~Object() {
    if (name_ != 0) {
      (api_->*Delete).call_quietly(1, &name_);
    }
  }

  [[nodiscard]] GLuint name() const { return name_; }

private:
  const Api* api_;
  GLuint name_ = 0;
};

using Buffer = Object<&Api::GenBuffers, &Api::DeleteBuffers>;
using Framebuffer = Object<&Api::GenFramebuffersEXT, &Api::DeleteFramebuffersEXT>;
using Query = Object<&Api::GenQueries, &Api::DeleteQueries>;
using Renderbuffer = Object<&Api::GenRenderbuffersEXT, &Api::DeleteRenderbuffersEXT>;
using Texture = Object<&Api::GenTextures, &Api::DeleteTextures>;

/// A linked program.
class Program {
public:
  struct Stage {
    GLenum type;
    std::string source;
  };
  /// Attribute 0 is called "corner" where there is a vertex shader. Throws DeviceError with the driver's log.
  Program(const Api& api, std::initializer_list<Stage> stages);
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program();

  void use() const;
  /// -1 where the driver dropped the uniform.
  [[nodiscard]] GLint uniform(const char* name) const;

private:
  const Api* api_;
  GLuint name_;
};

/// A shader of kernels/ as the driver wants it: `#include "energy.inc"` and `#include "gather.glsl"` replaced
/// by the texts, STEP_COUNT defined after the #version line.
[[nodiscard]] std::string assemble(std::string_view shader, int step_count);

} // namespace hdmbench::gl
