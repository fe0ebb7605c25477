// libEGL.so.1 as the backends see it under test.

#include "test/failing_calls/stand_in.hpp"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <utility>

namespace {

using namespace hdmbench::failing_calls;

EGLint pending = EGL_SUCCESS; ///< what eglGetError gives next

struct Egl : AnyApi {
  static constexpr const char* library = HDMBENCH_REAL_EGL;
  static constexpr std::string_view name = "EGL";

  template <typename Result, typename Real, typename... Arguments>
  static Result failure(std::string_view, Real, Arguments...) {
    pending = static_cast<EGLint>(code());
    return Result();
  }
};

FAILING_CALLS_NAME(eglBindAPI)
FAILING_CALLS_NAME(eglInitialize)
FAILING_CALLS_NAME(eglQueryString)
FAILING_CALLS_NAME(eglChooseConfig)
FAILING_CALLS_NAME(eglCreateContext)
FAILING_CALLS_NAME(eglDestroyContext)
FAILING_CALLS_NAME(eglMakeCurrent)
FAILING_CALLS_NAME(eglGetPlatformDisplayEXT)
FAILING_CALLS_NAME(eglQueryDevicesEXT)

bool before(NameeglBindAPI, EGLenum) {
  could_not_set_current(); // without it that is not tried
  return false;
}

bool before(NameeglDestroyContext, EGLDisplay, EGLContext context) {
  owner_gone(context);
  gl_context_gone(context);
  return true;
}

bool before(NameeglMakeCurrent, EGLDisplay, EGLSurface, EGLSurface, EGLContext context) {
  could_not_set_current(); // until it is
  return context == EGL_NO_CONTEXT;
}

void after(NameeglMakeCurrent, EGLBoolean done, EGLDisplay, EGLSurface, EGLSurface, EGLContext context) {
  if (done == EGL_TRUE) {
    set_current(context);
  }
}

} // namespace

FAILING_CALLS_EXPORT(Egl, eglBindAPI)
FAILING_CALLS_EXPORT(Egl, eglInitialize)
FAILING_CALLS_EXPORT(Egl, eglQueryString)
FAILING_CALLS_EXPORT(Egl, eglChooseConfig)
FAILING_CALLS_EXPORT(Egl, eglCreateContext)
FAILING_CALLS_EXPORT(Egl, eglDestroyContext)
FAILING_CALLS_EXPORT(Egl, eglMakeCurrent)

EXPORTED EGLint eglGetError() {
  static const auto real = real_function<decltype(&::eglGetError)>(Egl::library, "eglGetError");
  return pending != EGL_SUCCESS ? std::exchange(pending, EGL_SUCCESS) : real();
}

EXPORTED Address eglGetProcAddress(const char* name) {
  static const auto real = real_function<decltype(&::eglGetProcAddress)>(Egl::library, "eglGetProcAddress");
  const std::string_view asked = name;
  if (asked != "eglGetPlatformDisplayEXT" && asked != "eglQueryDevicesEXT") {
    return gl_stand_in(name, real(name));
  }
  if (is_missing("OpenGL", name)) {
    return nullptr;
  }
  return asked == "eglQueryDevicesEXT"
             ? place<StandIn<Egl, NameeglQueryDevicesEXT, PFNEGLQUERYDEVICESEXTPROC>>(real(name))
             : place<StandIn<Egl, NameeglGetPlatformDisplayEXT, PFNEGLGETPLATFORMDISPLAYEXTPROC>>(real(name));
}
