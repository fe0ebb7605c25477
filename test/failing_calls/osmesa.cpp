// libOSMesa.so.8 as the backends see it under test.

#include "test/failing_calls/stand_in.hpp"

#include <GL/osmesa.h>

namespace {

using namespace hdmbench::failing_calls;

struct OsMesa : AnyApi {
  static constexpr const char* library = HDMBENCH_REAL_OSMESA;
  static constexpr std::string_view name = "OSMesa";
  template <typename Result>
  static constexpr bool can_fail = !std::is_void_v<Result>;

  template <typename Result, typename Real, typename... Arguments>
  static Result failure(std::string_view, Real, Arguments...) {
    return Result();
  }
};

FAILING_CALLS_NAME(OSMesaCreateContextAttribs)
FAILING_CALLS_NAME(OSMesaDestroyContext)
FAILING_CALLS_NAME(OSMesaMakeCurrent)

bool before(NameOSMesaDestroyContext, OSMesaContext context) {
  owner_gone(context);
  gl_context_gone(context);
  return true;
}

bool before(NameOSMesaMakeCurrent, OSMesaContext context, void*, GLenum, GLsizei, GLsizei) {
  could_not_set_current(); // until it is
  return context == nullptr;
}

void after(NameOSMesaMakeCurrent, GLboolean done, OSMesaContext context, void*, GLenum, GLsizei, GLsizei) {
  if (done == GL_TRUE) {
    set_current(context);
  }
}

} // namespace

FAILING_CALLS_EXPORT(OsMesa, OSMesaCreateContextAttribs)
FAILING_CALLS_EXPORT(OsMesa, OSMesaDestroyContext)
FAILING_CALLS_EXPORT(OsMesa, OSMesaMakeCurrent)

EXPORTED OSMESAproc OSMesaGetProcAddress(const char* name) {
  static const auto real =
      real_function<decltype(&::OSMesaGetProcAddress)>(OsMesa::library, "OSMesaGetProcAddress");
  return gl_stand_in(name, real(name));
}
