// libEGL.so.1 as the backends see it under test.

#include "test/failing_calls/stand_in.hpp"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <string_view>
#include <utility>

namespace {

using namespace hdmbench::failing_calls;

EGLint pending = EGL_SUCCESS; ///< what eglGetError gives next
EGLContext lost = EGL_NO_CONTEXT;

const RealLibrary& real_library() {
  static const RealLibrary library(HDMBENCH_REAL_EGL);
  return library;
}

/// The function of the real libEGL.
#define REAL(name)                                                                                           \
  (+[] {                                                                                                     \
    static const auto function = real_library().function<decltype(&::name)>(#name);                          \
    return function;                                                                                         \
  }())

/// False: the call must do nothing.
bool proceeds(const char* name, bool cleans_up = false) {
  if (strikes(Event::egl_call, {.name = name, .can_fail_unnoticed = cleans_up})) {
    pending = static_cast<EGLint>(armed().code);
    return false;
  }
  return true;
}

PFNEGLGETPLATFORMDISPLAYEXTPROC real_get_platform_display = nullptr;
PFNEGLQUERYDEVICESEXTPROC real_query_devices = nullptr;

EGLDisplay get_platform_display(EGLenum platform, void* native, const EGLint* attributes) {
  return proceeds("eglGetPlatformDisplayEXT") ? real_get_platform_display(platform, native, attributes)
                                              : EGL_NO_DISPLAY;
}

EGLBoolean query_devices(EGLint room, EGLDeviceEXT* devices, EGLint* count) {
  if (!proceeds("eglQueryDevicesEXT")) {
    return EGL_FALSE;
  }
  // Mesa's surfaceless platform is the way on.
  if (strikes(Event::egl_answer, {.name = "the devices of EGL", .can_fail_unnoticed = true})) {
    *count = 0;
    return EGL_TRUE;
  }
  return real_query_devices(room, devices, count);
}

/// `stand_in` for a function of an extension; null where it is to be missing.
template <typename Function>
Address extension(const char* name, Function& real, Function stand_in) {
  real = reinterpret_cast<Function>(REAL(eglGetProcAddress)(name));
  return strikes(Event::look_up, {.name = name}) ? nullptr : reinterpret_cast<Address>(stand_in);
}

} // namespace

EXPORTED EGLint EGLAPIENTRY eglGetError() {
  return pending != EGL_SUCCESS ? std::exchange(pending, EGL_SUCCESS) : REAL(eglGetError)();
}

EXPORTED EGLBoolean EGLAPIENTRY eglBindAPI(EGLenum api) {
  if (!proceeds("eglBindAPI")) {
    could_not_set_current(); // without it that is not tried
    return EGL_FALSE;
  }
  return REAL(eglBindAPI)(api);
}

EXPORTED EGLBoolean EGLAPIENTRY eglInitialize(EGLDisplay display, EGLint* major, EGLint* minor) {
  return proceeds("eglInitialize") ? REAL(eglInitialize)(display, major, minor) : EGL_FALSE;
}

EXPORTED const char* EGLAPIENTRY eglQueryString(EGLDisplay display, EGLint name) {
  if (!proceeds("eglQueryString")) {
    return nullptr;
  }
  if (display == EGL_NO_DISPLAY
          ? strikes(Event::egl_answer, {.name = "the extensions of libEGL",
                                        .words = {"EGL has no device and no surfaceless platform"}})
          : strikes(Event::egl_answer, {.name = "the extensions of the display",
                                        .words = {"has no EGL_KHR_surfaceless_context"}})) {
    return "";
  }
  return REAL(eglQueryString)(display, name);
}

EXPORTED EGLBoolean EGLAPIENTRY eglChooseConfig(EGLDisplay display, const EGLint* attributes,
                                                EGLConfig* configs, EGLint room, EGLint* count) {
  if (!proceeds("eglChooseConfig")) {
    return EGL_FALSE;
  }
  if (strikes(Event::egl_answer,
              {.name = "the configurations of the display", .words = {"eglChooseConfig: no config"}})) {
    *count = 0;
    return EGL_TRUE;
  }
  return REAL(eglChooseConfig)(display, attributes, configs, room, count);
}

EXPORTED EGLContext EGLAPIENTRY eglCreateContext(EGLDisplay display, EGLConfig config, EGLContext share,
                                                 const EGLint* attributes) {
  if (!proceeds("eglCreateContext")) {
    return EGL_NO_CONTEXT;
  }
  EGLContext context = REAL(eglCreateContext)(display, config, share, attributes);
  if (context != EGL_NO_CONTEXT) {
    made("EGLContext", nullptr, reinterpret_cast<std::uintptr_t>(context));
  }
  return context;
}

EXPORTED EGLBoolean EGLAPIENTRY eglDestroyContext(EGLDisplay display, EGLContext context) {
  owner_gone(context);
  gl_context_gone(context);
  lost = lost == context ? EGL_NO_CONTEXT : lost;
  gone("EGLContext", nullptr, reinterpret_cast<std::uintptr_t>(context));
  return proceeds("eglDestroyContext", true) ? REAL(eglDestroyContext)(display, context) : EGL_FALSE;
}

EXPORTED EGLBoolean EGLAPIENTRY eglMakeCurrent(EGLDisplay display, EGLSurface draw, EGLSurface read,
                                               EGLContext context) {
  const bool release = context == EGL_NO_CONTEXT;
  could_not_set_current(); // until it is
  if (!release && context == lost) {
    pending = EGL_CONTEXT_LOST;
    return EGL_FALSE;
  }
  if (!release && strikes(Event::egl_current, {.name = "eglMakeCurrent"})) {
    pending = EGL_CONTEXT_LOST;
    lost = context;
    return EGL_FALSE;
  }
  if (!proceeds("eglMakeCurrent", release)) {
    return EGL_FALSE;
  }
  const EGLBoolean done = REAL(eglMakeCurrent)(display, draw, read, context);
  if (done == EGL_TRUE) {
    set_current(context);
  }
  return done;
}

EXPORTED __eglMustCastToProperFunctionPointerType EGLAPIENTRY eglGetProcAddress(const char* name) {
  const std::string_view asked = name;
  if (asked == "eglGetPlatformDisplayEXT") {
    return extension(name, real_get_platform_display, &get_platform_display);
  }
  if (asked == "eglQueryDevicesEXT") {
    return extension(name, real_query_devices, &query_devices);
  }
  return gl_stand_in(name, REAL(eglGetProcAddress)(name));
}
