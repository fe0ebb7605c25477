#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

struct Call {
  std::string name;       ///< of the function
  bool cleans_up = false; ///< its failure may go unnoticed
};

/// What the stand-ins share with the program that tests with them: which call fails, which ones there were,
/// and how much they made and have not destroyed. For one thread and one OpenGL context at a time.
class Faults {
public:
  /// HDMBENCH_FAILING_CALL="OpenGL/GL_OUT_OF_MEMORY/glReadPixels" arms any program. Throws
  /// std::invalid_argument where that is no API/kind/call.
  Faults();

  /// From now on the `at`-th (1, 2, ...) call that `kind` can befall fails, of missing functions the `at`-th
  /// name. 0: none does. Forgets what was counted.
  void arm(const Kind& kind, std::size_t at);
  /// All calls succeed.
  void disarm() { kind_ = nullptr; }
  /// What was done wrong since this was last asked, in words: calls without a context, what was destroyed
  /// twice or never made, what is left of all that was made, a context still current.
  [[nodiscard]] std::vector<std::string> take_complaints();

  // Since arm().
  std::vector<std::string> names;            ///< of the calls that could fail, or of what could be missing
  std::optional<Call> struck;                ///< the call that failed, or what was missing
  std::set<std::string, std::less<>> called; ///< functions, the failing ones included

  // For the stand-ins.

  /// Counts a call of an API that can fail. Returns the driver's code where it has to fail. `is_asked_for`:
  /// not the call is made but the function's address is asked for, of "OpenGL" (EGL's extensions with it) or
  /// "Vulkan"; where there is a code the function has to be missing.
  [[nodiscard]] std::optional<std::int64_t> failure(std::string_view api, const Call& call,
                                                    bool is_asked_for = false);
  void complain(std::string what) { complaints_.push_back(std::move(what)); }
  /// So many objects came to be, or went where `count` is below 0. The types of OpenGL begin with "gl".
  void made(std::string_view type, std::int64_t count);
  /// A context is about to go, and with it its objects, which should have gone before, unless it could not be
  /// made current for that.
  void end_context();

  const void* current = nullptr; ///< the OpenGL context of this thread
  bool binding_failed = false;   ///< since a context was made current the last time

private:
  const Kind* kind_ = nullptr;
  std::size_t at_ = 0;
  std::string only_;                          ///< name of the call that fails, instead of `at_`
  std::map<std::string, std::int64_t> alive_; ///< how many of a type
  std::vector<std::string> complaints_;
};

/// The one of this process: a shared library of its own holds it.
[[nodiscard]] Faults& faults();

} // namespace hdmbench::failing_calls
