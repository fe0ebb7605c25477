#pragma once

#include "harness/check/verify_windows.hpp"
#include "harness/cli/arguments.hpp"

#include <optional>
#include <string>

namespace hdmbench::commands {

/// Iterations per level of a --quick verify.
inline constexpr int quick_iterations = 10;

/// What verify --windows takes beside what verify takes.
struct WindowArguments {
  int windows = 0;       ///< of each large level; 0: no windows, but the whole image after every sweep
  int whole_side = 1024; ///< levels with as many sites as a square of this side are compared whole

  std::optional<LastLevel> last_level; ///< none: both, if there is memory for it

  void add_to(CLI::App& command);
};

/// One scene and backend after the other, because they are large. Returns an ExitStatus.
[[nodiscard]] int run_verify_windows(CommonArguments arguments, const WindowArguments& windows,
                                     const std::string& line);

} // namespace hdmbench::commands
