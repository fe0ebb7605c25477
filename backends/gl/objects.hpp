#pragma once

#include "backends/gl/api.hpp"
#include "backends/shared/energy_programs.hpp"
#include "backends/shared/timed.hpp"

#include <array>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hdmbench::gl {

/// Owns one OpenGL name: of glGen*s(1, &name), for glDelete*s(1, &name), or of glCreate*(argument...), for
/// glDelete*(name). The context must be current in constructor and destructor.
template <auto Make, auto Delete>
class Object {
public:
  template <typename... Arguments>
  explicit Object(const Api& api, Arguments... arguments) : api_(&api) {
    (api.*Delete).require();
    if constexpr (is_generated) {
      (api.*Make)(1, &name_);
    } else {
      name_ = (api.*Make)(arguments...);
    }
    if (name_ == 0) {
      throw_made_nothing((api.*Make).name());
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
    if (name_ == 0) {
      return;
    }
    if constexpr (is_generated) {
      api_->quietly(api_->*Delete, 1, &name_);
    } else {
      api_->quietly(api_->*Delete, name_);
    }
  }

  [[nodiscard]] GLuint name() const { return name_; }

private:
  static constexpr bool is_generated = requires(const Api& api, GLuint* names) { (api.*Make)(1, names); };

  const Api* api_;
  GLuint name_ = 0;
};

using Buffer = Object<&Api::GenBuffers, &Api::DeleteBuffers>;
using Framebuffer = Object<&Api::GenFramebuffersEXT, &Api::DeleteFramebuffersEXT>;
using Query = Object<&Api::GenQueries, &Api::DeleteQueries>;
using Renderbuffer = Object<&Api::GenRenderbuffersEXT, &Api::DeleteRenderbuffersEXT>;
using Texture = Object<&Api::GenTextures, &Api::DeleteTextures>;

/// Counts how long the device works, by its own clock. To be used while the context is current.
class Timer {
public:
  explicit Timer(const Api& api) : api_(&api) {}

  /// call(), whose drawings and dispatches are counted.
  template <typename Call>
  void operator()(const Call& call) {
    note();
    call();
    note();
  }
  /// Returns what Timed::device_seconds() does.
  [[nodiscard]] std::optional<double> device_seconds();
  /// Drops what was counted since the last call.
  void forget() noexcept { times_.clear(); }

private:
  /// The time when everything before is done.
  void note() {
    if (has_clock_) {
      api_->QueryCounter(times_.emplace_back(*api_).name(), GL_TIMESTAMP);
    }
  }

  const Api* api_;
  bool has_clock_ = false;   ///< found out at the first device_seconds()
  std::vector<Query> times_; ///< of begin and end in turn
  BusySeconds busy_;
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
  Object<&Api::CreateProgram, &Api::DeleteProgram> program_;
};

/// A shader of kernels/ as the driver wants it: with_own_texts(), and `definitions` after the #version line.
[[nodiscard]] std::string assemble(std::string_view shader, std::string_view definitions,
                                   const Energy& energy = thesis_energy, const Law* law = nullptr);
/// With definitions(constants).
[[nodiscard]] std::string assemble(std::string_view shader, const ShaderConstants& constants);

/// RULE, COLOURS and STEP_COUNT.
[[nodiscard]] std::string definitions(const ShaderConstants& constants);

/// STEPS, the candidates as constants. Nine digits are a float to the bit, whether a driver reads them as
/// such or as a double.
[[nodiscard]] std::string steps_definition(const std::array<float, 16>& steps);

} // namespace hdmbench::gl
