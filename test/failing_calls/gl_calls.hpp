#pragma once

namespace hdmbench::failing_calls {

using Address = void (*)();

/// The stand-in for the function of OpenGL of this name, which forwards to `real`; null where the armed fault
/// is that it is missing. A name that backends/gl/api.hpp does not have, which would escape the test, is
/// complained about.
[[nodiscard]] Address gl_stand_in(const char* name, Address real);

/// A context is no more; another one may get its address.
void gl_context_gone(const void* context);

} // namespace hdmbench::failing_calls
