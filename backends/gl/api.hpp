#pragma once

#include "backends/backend.hpp"

#define GL_GLEXT_PROTOTYPES // for decltype only: nothing is linked against libGL
#include <GL/gl.h>
#include <GL/glext.h>
#undef GL_GLEXT_PROTOTYPES

#include <functional>
#include <type_traits>
#include <utility>

namespace hdmbench::gl {

using Address = void (*)();
using Resolver = std::function<Address(const char*)>;

/// Throws DeviceError("NAME: GL_OUT_OF_MEMORY") if an error is pending; `get_error` is glGetError.
void throw_pending_error(const char* name, GLenum (*get_error)());
/// Throws DeviceError: the driver has no such function.
[[noreturn]] void throw_missing(const char* name);
/// Throws DeviceError: glGen* or glCreate* gave the name 0, without an error.
[[noreturn]] void throw_made_nothing(const char* name);

template <typename Pointer>
class Function;

/// An OpenGL function that checks for errors after every call: none can be forgotten.
template <typename Result, typename... Arguments>
class Function<Result (*)(Arguments...)> {
public:
  Function(const char* name, const Resolver& resolve)
      : name_(name), pointer_(reinterpret_cast<Result (*)(Arguments...)>(resolve(name))),
        get_error_(reinterpret_cast<GLenum (*)()>(resolve("glGetError"))) {}

  [[nodiscard]] const char* name() const { return name_; }

  /// Throws DeviceError unless the driver has it. For what is called quietly later.
  void require() const {
    if (pointer_ == nullptr) {
      throw_missing(name_);
    }
    if (get_error_ == nullptr) {
      throw_missing("glGetError");
    }
  }

  Result operator()(Arguments... arguments) const {
    require();
    if constexpr (std::is_void_v<Result>) {
      pointer_(arguments...);
      throw_pending_error(name_, get_error_);
    } else {
      const Result result = pointer_(arguments...);
      throw_pending_error(name_, get_error_);
      return result;
    }
  }

  /// Errors are dropped.
  void call_quietly(Arguments... arguments) const noexcept {
    if (pointer_ != nullptr && get_error_ != nullptr) {
      pointer_(arguments...);
      get_error_();
    }
  }

private:
  const char* name_;
  Result (*pointer_)(Arguments...);
  GLenum (*get_error_)();
};

/// The functions the backends use, as one context's driver has them. The member for glXyz is called Xyz.
struct Api {
  explicit Api(Resolver resolver) : resolve(std::move(resolver)) {}

  /// Calls one of the functions below for a destructor: errors are dropped.
  template <typename Pointer, typename... Arguments>
  void quietly(const Function<Pointer>& function, Arguments... arguments) const noexcept {
    if (!abandoned) {
      function.call_quietly(arguments...);
    }
  }

  Resolver resolve;
  /// The context can no longer be made current. Its objects go when it goes; who calls now meets no context,
  /// or that of somebody else.
  bool abandoned = false;

#define HDMBENCH_GL(name)                                                                                    \
  Function<decltype(&::gl##name)> name {                                                                     \
    "gl" #name, resolve                                                                                      \
  }
  // OpenGL 2.1
  HDMBENCH_GL(ActiveTexture);
  HDMBENCH_GL(AttachShader);
  HDMBENCH_GL(BeginQuery);
  HDMBENCH_GL(BindAttribLocation);
  HDMBENCH_GL(BindBuffer);
  HDMBENCH_GL(BindTexture);
  HDMBENCH_GL(BufferData);
  HDMBENCH_GL(BufferSubData);
  HDMBENCH_GL(CompileShader);
  HDMBENCH_GL(CreateProgram);
  HDMBENCH_GL(CreateShader);
  HDMBENCH_GL(DeleteBuffers);
  HDMBENCH_GL(DeleteProgram);
  HDMBENCH_GL(DeleteQueries);
  HDMBENCH_GL(DeleteShader);
  HDMBENCH_GL(DeleteTextures);
  HDMBENCH_GL(DrawArrays);
  HDMBENCH_GL(EnableVertexAttribArray);
  HDMBENCH_GL(EndQuery);
  HDMBENCH_GL(Finish);
  HDMBENCH_GL(GenBuffers);
  HDMBENCH_GL(GenQueries);
  HDMBENCH_GL(GenTextures);
  HDMBENCH_GL(GetIntegerv);
  HDMBENCH_GL(GetProgramInfoLog);
  HDMBENCH_GL(GetProgramiv);
  HDMBENCH_GL(GetQueryObjectuiv);
  HDMBENCH_GL(GetQueryiv);
  HDMBENCH_GL(GetShaderInfoLog);
  HDMBENCH_GL(GetShaderiv);
  HDMBENCH_GL(GetString);
  HDMBENCH_GL(GetUniformLocation);
  HDMBENCH_GL(LinkProgram);
  HDMBENCH_GL(PointSize);
  HDMBENCH_GL(ReadPixels);
  HDMBENCH_GL(ShaderSource);
  HDMBENCH_GL(TexImage2D);
  HDMBENCH_GL(TexParameteri);
  HDMBENCH_GL(TexSubImage2D);
  HDMBENCH_GL(Uniform1f);
  HDMBENCH_GL(Uniform1fv);
  HDMBENCH_GL(Uniform1i);
  HDMBENCH_GL(Uniform1iv);
  HDMBENCH_GL(Uniform2f);
  HDMBENCH_GL(Uniform3f);
  HDMBENCH_GL(Uniform4f);
  HDMBENCH_GL(UseProgram);
  HDMBENCH_GL(VertexAttribPointer);
  HDMBENCH_GL(Viewport);
  // EXT_framebuffer_object
  HDMBENCH_GL(BindFramebufferEXT);
  HDMBENCH_GL(BindRenderbufferEXT);
  HDMBENCH_GL(CheckFramebufferStatusEXT);
  HDMBENCH_GL(DeleteFramebuffersEXT);
  HDMBENCH_GL(DeleteRenderbuffersEXT);
  HDMBENCH_GL(FramebufferRenderbufferEXT);
  HDMBENCH_GL(FramebufferTexture2DEXT);
  HDMBENCH_GL(GenFramebuffersEXT);
  HDMBENCH_GL(GenRenderbuffersEXT);
  HDMBENCH_GL(RenderbufferStorageEXT);
  // ARB_timer_query
  HDMBENCH_GL(GetQueryObjectui64v);
  HDMBENCH_GL(QueryCounter);
  // OpenGL 4.3
  HDMBENCH_GL(BindBufferBase);
  HDMBENCH_GL(BindImageTexture);
  HDMBENCH_GL(ClearBufferSubData);
  HDMBENCH_GL(CopyBufferSubData);
  HDMBENCH_GL(DispatchCompute);
  HDMBENCH_GL(GetBufferSubData);
  HDMBENCH_GL(MemoryBarrier);
  HDMBENCH_GL(TexBuffer);
#undef HDMBENCH_GL
};

} // namespace hdmbench::gl
