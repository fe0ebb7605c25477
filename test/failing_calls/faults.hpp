#pragma once

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// What the stand-ins for libEGL, libOSMesa, libvulkan and libOpenCL share with the program that tests with
/// them: which call fails, how many there were, and what they made and have not destroyed. One thread only.
/// Lives in a shared library of its own, so that there is one of it in a process.
namespace hdmbench::failing_calls {

/// A way to fail.
struct Kind {
  std::string_view api;    ///< "EGL", "OSMesa", "OpenGL", "Vulkan", "OpenCL"
  std::string_view name;   ///< "GL_OUT_OF_MEMORY", or `missing`
  std::int64_t code;       ///< of the driver: the GLenum, EGLint, VkResult or cl_int
  std::string_view reason; ///< must be in the message
};
/// A function is not there whenever it is asked for; all other kinds let one call fail.
inline constexpr std::string_view missing = "function missing";

[[nodiscard]] std::span<const Kind> kinds();

/// A call that can fail.
struct Call {
  std::string name;
  std::vector<std::string> words{}; ///< one of them must be in the message; empty: the name
  bool can_fail_unnoticed = false;  ///< it cleans up
};

/// From now on the `at`-th (1, 2, ...) call that `kind` can befall fails, of missing functions the `at`-th
/// name. 0: none does. Forgets what was counted.
void arm(const Kind& kind, int at);
/// All calls succeed.
void disarm();

struct Tally {
  int calls = 0;                               ///< that could have failed
  std::vector<std::string> names{};            ///< of these, in order; none of functions that are missing
  bool struck = false;                         ///< one did
  Call call{};                                 ///< that one
  std::set<std::string, std::less<>> called{}; ///< functions, the failing ones included
};
/// Since arm().
[[nodiscard]] const Tally& tally();

/// What was done wrong since this was last asked, in words: calls without a context, what was destroyed twice
/// or never made, what is left of all that was made, a context still current.
[[nodiscard]] std::vector<std::string> take_complaints();

// For the stand-ins.

/// Whether this call of an API has to fail, or this function of OpenGL, EGL or Vulkan to be missing. Counts
/// it.
[[nodiscard]] bool fails(std::string_view api, const Call& call);
[[nodiscard]] bool is_missing(std::string_view api, std::string_view name);
/// Of the kind that made it fail.
[[nodiscard]] std::int64_t code();
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
