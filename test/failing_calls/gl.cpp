#include "test/failing_calls/stand_in.hpp"

#define GL_GLEXT_PROTOTYPES // for decltype only: nothing is linked against libGL
#include <GL/gl.h>
#include <GL/glext.h>
#include <fmt/format.h>

#include <utility>

// Compiled into libEGL and libOSMesa each, with hidden symbols: the addresses of the one's driver are not the
// other's.
namespace hdmbench::failing_calls {

namespace {

GLenum pending = GL_NO_ERROR; ///< what glGetError gives next
const void* lost = nullptr;   ///< a context that is lost
void (*real_finish)() = nullptr;

#define FUNCTION(name)                                                                                       \
  struct Name##name {                                                                                        \
    static constexpr std::string_view text = "gl" #name;                                                     \
  };
#include <gl_functions.inc>
#undef FUNCTION

struct OpenGl : AnyApi {
  static constexpr std::string_view name = "OpenGL";

  static const void* owner() { return current(); }
  static bool proceeds(std::string_view name) {
    if (current() == nullptr) {
      complain(fmt::format("{} was called without a current context", name));
    }
    return current() != nullptr && current() != lost;
  }
  template <typename Result, typename Real, typename... Arguments>
  static Result failure(std::string_view, Real, Arguments...) {
    if (code() != GL_CONTEXT_LOST) {
      pending = static_cast<GLenum>(code());
    } else {
      lost = current();
      if (real_finish != nullptr) {
        real_finish(); // what is lost draws no more
      }
    }
    return Result();
  }
};

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

} // namespace

void gl_context_gone(const void* context) {
  lost = lost == context ? nullptr : lost;
}

Address gl_stand_in(const char* name, Address real) {
  const std::string_view asked = name;
  if (asked == "glFinish") {
    real_finish = real;
  }
  if (real == nullptr || is_missing("OpenGL", name)) {
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
