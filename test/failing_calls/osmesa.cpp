// libOSMesa.so.8 as the backends see it under test.

#include "test/failing_calls/stand_in.hpp"

#include <GL/osmesa.h>

namespace {

using namespace hdmbench::failing_calls;

const RealLibrary& real_library() {
  static const RealLibrary library(HDMBENCH_REAL_OSMESA);
  return library;
}

} // namespace

EXPORTED OSMesaContext OSMesaCreateContextAttribs(const int* attributes, OSMesaContext share) {
  static const auto real =
      real_library().function<decltype(&::OSMesaCreateContextAttribs)>("OSMesaCreateContextAttribs");
  if (strikes(Event::osmesa_call, {.name = "OSMesaCreateContextAttribs"})) {
    return nullptr;
  }
  OSMesaContext context = real(attributes, share);
  if (context != nullptr) {
    made("OSMesaContext", nullptr, reinterpret_cast<std::uintptr_t>(context));
  }
  return context;
}

EXPORTED void OSMesaDestroyContext(OSMesaContext context) {
  static const auto real = real_library().function<decltype(&::OSMesaDestroyContext)>("OSMesaDestroyContext");
  owner_gone(context);
  gl_context_gone(context);
  gone("OSMesaContext", nullptr, reinterpret_cast<std::uintptr_t>(context));
  real(context);
}

EXPORTED GLboolean OSMesaMakeCurrent(OSMesaContext context, void* buffer, GLenum type, GLsizei width,
                                     GLsizei height) {
  static const auto real = real_library().function<decltype(&::OSMesaMakeCurrent)>("OSMesaMakeCurrent");
  could_not_set_current(); // until it is
  if (strikes(Event::osmesa_call, {.name = "OSMesaMakeCurrent", .can_fail_unnoticed = context == nullptr})) {
    return GL_FALSE;
  }
  const GLboolean done = real(context, buffer, type, width, height);
  if (done == GL_TRUE) {
    set_current(context);
  }
  return done;
}

EXPORTED OSMESAproc OSMesaGetProcAddress(const char* name) {
  static const auto real = real_library().function<decltype(&::OSMesaGetProcAddress)>("OSMesaGetProcAddress");
  return gl_stand_in(name, real(name));
}
