#include "test/failing_calls/gl_calls.hpp"

#include "test/failing_calls/faults.hpp"

#define GL_GLEXT_PROTOTYPES // for decltype only: nothing is linked against libGL
#include <GL/gl.h>
#include <GL/glext.h>
#include <fmt/format.h>

#include <algorithm>
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

/// What all stand-ins begin with. False: the call must do nothing.
bool proceeds(std::string_view name) {
  note_call(name);
  if (current() == nullptr) {
    complain(fmt::format("{} was called without a current context", name));
    return false;
  }
  if (lost == current()) {
    return false;
  }
  if (strikes(Event::gl_call,
              {.name = std::string(name), .can_fail_unnoticed = name.starts_with("glDelete")})) {
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
  return true;
}

/// "Texture" of "glGenTextures" and "glDeleteTextures".
std::string_view type_of(std::string_view name) {
  name.remove_prefix(name.starts_with("glGen") ? 5 : name.starts_with("glDelete") ? 8 : 0);
  return name;
}

// What some functions do besides being forwarded, by name; all others do nothing. `Name` is a type per
// function.
#define FUNCTION(name)                                                                                       \
  struct Name##name {                                                                                        \
    static constexpr std::string_view text = "gl" #name;                                                     \
  };
#include <gl_functions.inc>
#undef FUNCTION

/// Objects in numbers: glGen*(n, names) and glDelete*(n, names).
template <typename Forward>
void generate(std::string_view name, GLsizei count, GLuint* names, Forward&& forward) {
  if (strikes(Event::gl_name, {.name = std::string(name)})) {
    std::fill_n(names, count, 0U);
    return;
  }
  forward();
  for (GLsizei i = 0; i < count; ++i) {
    made(type_of(name), current(), names[i]);
  }
}

void note_deleted(std::string_view name, GLsizei count, const GLuint* names) {
  for (GLsizei i = 0; i < count; ++i) {
    if (names[i] != 0) {
      gone(type_of(name), current(), names[i]);
    }
  }
}

template <typename Forward>
GLuint create(std::string_view type, Forward&& forward) {
  if (strikes(Event::gl_name, {.name = fmt::format("glCreate{}", type)})) {
    return 0;
  }
  const GLuint name = forward();
  made(type, current(), name);
  return name;
}

void refuse(GLenum asked, GLenum status, std::string_view call, GLint* answer) {
  if (asked == status && strikes(Event::gl_compilation, {.name = std::string(call)})) {
    compilation_refused = true;
    *answer = GL_FALSE;
  } else if (asked == status) {
    compilation_refused = false;
  } else if (asked == GL_INFO_LOG_LENGTH && compilation_refused) {
    *answer = static_cast<GLint>(planted_log.size() + 1);
  }
}

void give_log(GLsizei* length, GLchar* log) {
  if (compilation_refused) {
    std::memcpy(log, planted_log.data(), planted_log.size());
    *length = static_cast<GLsizei>(planted_log.size());
  }
}

void limit(GLenum asked, GLint* answer) {
  constexpr GLint too_small = 2;
  if (asked == GL_MAX_RECTANGLE_TEXTURE_SIZE_ARB &&
      strikes(Event::gl_answer,
              {.name = "GL_MAX_RECTANGLE_TEXTURE_SIZE", .words = {"rectangle textures end at 2 x 2"}})) {
    *answer = too_small;
  }
  if (asked == GL_MAX_TEXTURE_BUFFER_SIZE &&
      strikes(Event::gl_answer,
              {.name = "GL_MAX_TEXTURE_BUFFER_SIZE", .words = {"texel buffer elements are needed, the device has 2"}})) {
    *answer = too_small;
  }
}

template <typename Name, typename Pointer>
struct StandIn;

template <typename Name, typename Result, typename... Arguments>
struct StandIn<Name, Result (*)(Arguments...)> {
  static inline Result (*real)(Arguments...) = nullptr;

  static Result call(Arguments... arguments) {
    constexpr std::string_view name = Name::text;
    if constexpr (name.starts_with("glDelete") && sizeof...(Arguments) == 2) {
      note_deleted(name, arguments...);
    } else if constexpr (name.starts_with("glDelete")) {
      const GLuint deleted = (arguments, ...);
      note_deleted(name, 1, &deleted);
    }
    if (!proceeds(name)) {
      return Result();
    }
    if constexpr (name.starts_with("glGen")) {
      const auto forward = [&] { real(arguments...); };
      const auto split = [&](GLsizei count, GLuint* names) { generate(name, count, names, forward); };
      split(arguments...);
    } else if constexpr (name.starts_with("glCreate")) {
      return create(name.substr(8), [&] { return real(arguments...); });
    } else if constexpr (name == "glGetShaderiv" || name == "glGetProgramiv") {
      real(arguments...);
      const auto split = [](GLuint, GLenum asked, GLint* answer) {
        constexpr bool shader = name == "glGetShaderiv";
        refuse(asked, shader ? GL_COMPILE_STATUS : GL_LINK_STATUS,
               shader ? "glCompileShader" : "glLinkProgram", answer);
      };
      split(arguments...);
    } else if constexpr (name == "glGetShaderInfoLog" || name == "glGetProgramInfoLog") {
      real(arguments...);
      const auto split = [](GLuint, GLsizei, GLsizei* length, GLchar* log) { give_log(length, log); };
      split(arguments...);
    } else if constexpr (name == "glGetIntegerv") {
      real(arguments...);
      limit(arguments...);
    } else if constexpr (name == "glGetString") {
      if ((arguments, ...) == GL_VERSION &&
          strikes(Event::gl_answer, {.name = "GL_VERSION", .words = {"offers OpenGL 1.4 of the stand-in"}})) {
        return reinterpret_cast<const GLubyte*>("1.4 of the stand-in");
      }
      return real(arguments...);
    } else if constexpr (name == "glCheckFramebufferStatusEXT") {
      return strikes(Event::gl_framebuffer, {.name = std::string(name)}) ? static_cast<GLenum>(armed().code)
                                                                         : real(arguments...);
    } else {
      return real(arguments...);
    }
  }
};

/// Not among the calls that can fail: it is how they say so.
struct NameGetError {};
template <>
struct StandIn<NameGetError, GLenum (*)()> {
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
    return place<StandIn<NameGetError, decltype(&::glGetError)>>(real);
  }
#define FUNCTION(known)                                                                                      \
  if (asked == "gl" #known) {                                                                                \
    return place<StandIn<Name##known, decltype(&::gl##known)>>(real);                                        \
  }
#include <gl_functions.inc>
#undef FUNCTION
  complain(fmt::format("{} has no stand-in", name));
  return real;
}

} // namespace hdmbench::failing_calls
