#include "test/failing_calls/stand_in.hpp"

#define GL_GLEXT_PROTOTYPES // for decltype only: nothing is linked against libGL
#include <GL/gl.h>
#include <GL/glext.h>
#include <fmt/format.h>

#include <cstring>
#include <string_view>
#include <utility>

// Compiled into libEGL and libOSMesa each, with hidden symbols: the addresses of the one's driver are not the
// other's.
namespace hdmbench::failing_calls {

namespace {

constexpr std::string_view planted_log = "error: the planted log\n";

GLenum pending = GL_NO_ERROR; ///< what glGetError gives next
const void* lost = nullptr;   ///< a context that is lost
void (*real_finish)() = nullptr;
bool compilation_refused = false; ///< the log to give is planted_log

#define FUNCTION(name)                                                                                       \
  struct Name##name {                                                                                        \
    static constexpr std::string_view text = "gl" #name;                                                     \
  };
#include <gl_functions.inc>
#undef FUNCTION

struct OpenGl {
  template <typename>
  static constexpr bool returns_status = false;

  static const void* owner() { return current(); }
  template <typename>
  static bool proceeds(std::string_view name) {
    if (current() == nullptr) {
      complain(fmt::format("{} was called without a current context", name));
      return false;
    }
    if (lost == current()) {
      return false;
    }
    if (!strikes(Event::gl_call,
                 {.name = std::string(name), .can_fail_unnoticed = name.starts_with("glDelete")})) {
      return true;
    }
    if (armed().code == GL_CONTEXT_LOST) {
      lost = current();
      if (real_finish != nullptr) {
        real_finish(); // what is lost draws no more
      }
    } else {
      pending = static_cast<GLenum>(armed().code);
    }
    return false;
  }
  template <typename Result, typename Real, typename... Arguments>
  static Result failure(std::string_view, Real, Arguments...) {
    return Result();
  }
  static bool makes_nothing(std::string_view name) {
    return strikes(Event::gl_name, {.name = std::string(name)});
  }
  template <typename Result>
  static bool succeeded(Result) {
    return true;
  }
};

void refuse(GLenum asked, GLenum status, const char* call, GLint* answer) {
  if (asked == status && strikes(Event::gl_compilation, {.name = call})) {
    compilation_refused = true;
    *answer = GL_FALSE;
  } else if (asked == status) {
    compilation_refused = false;
  } else if (asked == GL_INFO_LOG_LENGTH && compilation_refused) {
    *answer = static_cast<GLint>(planted_log.size() + 1);
  }
}

void answered(NameGetShaderiv, GLuint, GLenum asked, GLint* answer) {
  refuse(asked, GL_COMPILE_STATUS, "glCompileShader", answer);
}

void answered(NameGetProgramiv, GLuint, GLenum asked, GLint* answer) {
  refuse(asked, GL_LINK_STATUS, "glLinkProgram", answer);
}

void give_log(GLsizei* length, GLchar* log) {
  if (compilation_refused) {
    std::memcpy(log, planted_log.data(), planted_log.size());
    *length = static_cast<GLsizei>(planted_log.size());
  }
}

void answered(NameGetShaderInfoLog, GLuint, GLsizei, GLsizei* length, GLchar* log) {
  give_log(length, log);
}

void answered(NameGetProgramInfoLog, GLuint, GLsizei, GLsizei* length, GLchar* log) {
  give_log(length, log);
}

bool lies(const char* what, const char* words) {
  return strikes(Event::gl_answer, {.name = what, .words = {words}});
}

void answered(NameGetIntegerv, GLenum asked, GLint* answer) {
  constexpr GLint too_small = 2;
  if ((asked == GL_MAX_RECTANGLE_TEXTURE_SIZE_ARB &&
       lies("GL_MAX_RECTANGLE_TEXTURE_SIZE", "rectangle textures end at 2 x 2")) ||
      (asked == GL_MAX_TEXTURE_BUFFER_SIZE &&
       lies("GL_MAX_TEXTURE_BUFFER_SIZE", "texel buffer elements are needed, the device has 2"))) {
    *answer = too_small;
  }
}

const GLubyte* special(NameGetString, auto real, GLenum asked) {
  return asked == GL_VERSION && lies("GL_VERSION", "offers OpenGL 1.4 of the stand-in")
             ? reinterpret_cast<const GLubyte*>("1.4 of the stand-in")
             : real(asked);
}

GLenum special(NameCheckFramebufferStatusEXT, auto real, GLenum target) {
  return strikes(Event::gl_framebuffer, {.name = "glCheckFramebufferStatusEXT"})
             ? static_cast<GLenum>(armed().code)
             : real(target);
}

/// Not among the calls that can fail: it is how they say so.
struct GetError {
  static inline GLenum (*real)() = nullptr;

  static GLenum call() {
    note_call("glGetError");
    if (current() == nullptr) {
      complain("glGetError was called without a current context");
    }
    if (lost != nullptr && lost == current()) {
      return GL_CONTEXT_LOST; // every time: whoever waits for the last error waits for ever
    }
    return pending != GL_NO_ERROR ? std::exchange(pending, GL_NO_ERROR) : real();
  }
};

template <typename StandIn>
Address place(Address real) {
  StandIn::real = reinterpret_cast<decltype(StandIn::real)>(real);
  return reinterpret_cast<Address>(&StandIn::call);
}

} // namespace

void gl_context_gone(const void* context) {
  lost = lost == context ? nullptr : lost;
}

Address gl_stand_in(const char* name, Address real) {
  const std::string_view asked = name;
  if (asked == "glFinish") {
    real_finish = real;
  }
  if (real == nullptr || strikes(Event::look_up, {.name = name})) {
    return nullptr;
  }
  if (asked == "glGetError") {
    return place<GetError>(real);
  }
#define FUNCTION(known)                                                                                      \
  if (asked == "gl" #known) {                                                                                \
    return place<StandIn<OpenGl, Name##known, decltype(&::gl##known)>>(real);                                \
  }
#include <gl_functions.inc>
#undef FUNCTION
  complain(fmt::format("{} has no stand-in", name));
  return real;
}

} // namespace hdmbench::failing_calls
