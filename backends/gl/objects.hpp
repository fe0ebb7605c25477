#pragma once

#include "backends/gl/api.hpp"
#include "backends/shared/shader_constants.hpp"

#include <array>
#include <map>
#include <string>
#include <utility>

namespace hdmbench::gl {

/// Owns one OpenGL name that glDelete*s(1, &name) gives back. The context must be current in constructor and
/// destructor.
template <auto Generate, auto Delete>
class Object {
public:
  explicit Object(const Api& api) : api_(&api) {
    (api.*Delete).require();
    (api.*Generate)(1, &name_);
    if (name_ == 0) {
      throw_made_nothing((api.*Generate).name());
    }
  }
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
      api_->quietly(api_->*Delete, 1, &name_);
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

/// Owns what glCreate*(argument...) made, for glDelete*(name). As Object otherwise.
template <auto Create, auto Delete>
class CreatedObject {
public:
  template <typename... Arguments>
  explicit CreatedObject(const Api& api, Arguments... arguments)
      : api_(&api), name_(create(api, arguments...)) {}
  CreatedObject(const CreatedObject&) = delete;
  CreatedObject& operator=(const CreatedObject&) = delete;
  ~CreatedObject() { api_->quietly(api_->*Delete, name_); }

  [[nodiscard]] GLuint name() const { return name_; }

private:
  template <typename... Arguments>
  static GLuint create(const Api& api, Arguments... arguments) {
    (api.*Delete).require();
    const GLuint name = (api.*Create)(arguments...);
    if (name == 0) {
      throw_made_nothing((api.*Create).name());
    }
    return name;
  }

  const Api* api_;
  GLuint name_;
};

/// A linked program.
class Program {
public:
  struct Stage {
    GLenum type;
    std::string source;
  };
  /// Attribute 0 is called "corner" where there is a vertex shader. Throws DeviceError with the driver's log.
  Program(const Api& api, std::initializer_list<Stage> stages);

  void use() const;
  /// -1 where the driver dropped the uniform.
  [[nodiscard]] GLint uniform(const char* name) const;

private:
  const Api* api_;
  CreatedObject<&Api::CreateProgram, &Api::DeleteProgram> program_;
};

/// A shader of kernels/ as the driver wants it: `#include "..."` replaced by the texts, `definitions` after
/// the #version line.
[[nodiscard]] std::string assemble(std::string_view shader, std::string_view definitions,
                                   const Energy& energy = thesis_energy);
/// With definitions(constants).
[[nodiscard]] std::string assemble(std::string_view shader, const ShaderConstants& constants);

/// RULE, COLOURS and STEP_COUNT.
[[nodiscard]] std::string definitions(const ShaderConstants& constants);

/// STEPS, the candidates as constants. Nine digits are a float to the bit, whether a driver reads them as
/// such or as a double.
[[nodiscard]] std::string steps_definition(const std::array<float, 16>& steps);

/// The sweep of one kind of level, ready to run.
struct SweepProgram {
  Program program;
  GLint
      turn; ///< location of the uniform that changes from sweep to sweep, -1 where the rule has no such thing

  SweepProgram(const Api& api, std::initializer_list<Program::Stage> stages)
      : program(api, stages), turn(program.uniform("turn")) {}

  /// The program must be in use.
  void set_turn(const Api& api, const SweepState& state) const;
};

/// Programs by what they were compiled for: going back to a rule or a level compiles nothing.
using SweepPrograms = std::map<ShaderConstants, SweepProgram>;

} // namespace hdmbench::gl
