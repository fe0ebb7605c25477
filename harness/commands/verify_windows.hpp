#pragma once

#include "harness/commands/arguments.hpp"

#include <string>

namespace hdmbench::commands {

/// Iterations per level of a --quick verify.
inline constexpr int quick_iterations = 10;

/// What verify --windows takes beside what verify takes.
struct WindowArguments {
  int windows = 0;       ///< of each large level; 0: no windows, but the whole image after every sweep
  int whole_side = 1024; ///< levels with as many sites as a square of this side are compared whole

  bool levels_only = false; ///< do not solve in one piece, which may need a second copy of all levels

  void add_to(CLI::App& command);
};

/// One scene and backend after the other, because they are large. Returns an ExitStatus.
[[nodiscard]] int run_verify_windows(CommonArguments arguments, const WindowArguments& windows,
                                     const std::string& line);

} // namespace hdmbench::commands
