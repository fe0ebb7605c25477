#pragma once

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// What the stand-ins for libEGL, libOSMesa, libvulkan and libOpenCL share with the program that tests with
/// them: which call fails, how many there were, and what they made and have not destroyed. A stand-in
/// forwards every call to the library whose name it bears, but for the one that is to fail. One thread only.
/// Lives in a shared library of its own, so that there is one of it in a process.
namespace hdmbench::failing_calls {

/// Where a fault can strike.
enum class Event {
  egl_call,       ///< any call of EGL but eglGetError and eglGetProcAddress
  egl_current,    ///< eglMakeCurrent of a context, from then on
  egl_answer,     ///< what EGL offers
  osmesa_call,    ///< any call of OSMesa but OSMesaGetProcAddress
  gl_call,        ///< any call of OpenGL but glGetError
  gl_name,        ///< glGen* and glCreate*
  gl_framebuffer, ///< glCheckFramebufferStatusEXT
  gl_compilation, ///< glCompileShader and glLinkProgram
  gl_answer,      ///< what the context can do
  vulkan_call,    ///< any call that returns a VkResult
  vulkan_answer,  ///< what the devices can do
  opencl_call,    ///< any call of OpenCL
  opencl_build,   ///< clBuildProgram
  opencl_answer,  ///< what the devices can do
  look_up         ///< a function is asked for by name
};

/// A way to fail.
struct Kind {
  std::string_view name; ///< "GL_OUT_OF_MEMORY"
  std::string_view api;  ///< "EGL", "OSMesa", "OpenGL", "Vulkan", "OpenCL"
  Event event;
  std::int64_t code = 0;     ///< of the driver: the GLenum, EGLint, VkResult or cl_int
  std::string_view reason{}; ///< must be in the message
  bool for_good = false;     ///< what failed once keeps failing: a lost context, a function that is missing
};

[[nodiscard]] std::span<const Kind> kinds();
/// Throws std::invalid_argument.
[[nodiscard]] const Kind& kind_of(std::string_view api, std::string_view name);

/// A call that a fault of the armed kind can befall.
struct Call {
  std::string name;
  std::vector<std::string> words{}; ///< one of them must be in the message; empty: the name
  /// The work can be done without it: what cleans up, a function that nobody calls, what has an alternative.
  bool can_fail_unnoticed = false;
};

/// From now on the `at`-th (1, 2, ...) call that `kind` can befall fails; kinds for good count names instead
/// of calls. 0: none does. Forgets what was counted.
void arm(const Kind& kind, int at);
/// All calls succeed.
void disarm();

struct Tally {
  int calls = 0;       ///< that could have been struck
  bool struck = false; ///< the fault was felt
  Call call{};         ///< the one that failed
  std::set<std::string, std::less<>>
      called{}; ///< functions of OpenGL, Vulkan and OpenCL, the failing ones included
};
/// Since arm().
[[nodiscard]] const Tally& tally();

/// What was done wrong since this was last asked, in words: calls without a context, what was destroyed twice
/// or never made, what is left of all that was made, a context still current.
[[nodiscard]] std::vector<std::string> take_complaints();

// For the stand-ins.

/// Whether this call has to fail: the armed kind strikes at `event` and it is this one's turn. Counts it.
[[nodiscard]] bool strikes(Event event, const Call& call);
/// The armed kind. Only after strikes().
[[nodiscard]] const Kind& armed();
/// Counts a function that was called, whether it can fail or not.
void note_call(std::string_view name);
void complain(std::string what);
/// An object came to be or went. `owner` tells the names of two contexts apart.
void made(std::string_view type, const void* owner, std::uint64_t handle);
void gone(std::string_view type, const void* owner, std::uint64_t handle);
/// A context goes and takes what it owns along; whatever that is should have gone before, unless the context
/// could not be made current for it.
void owner_gone(const void* owner);
/// The OpenGL context of this thread, null: none.
void set_current(const void* context);
/// It stayed what it was.
void could_not_set_current();
[[nodiscard]] const void* current();

} // namespace hdmbench::failing_calls
