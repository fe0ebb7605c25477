#pragma once

#include "harness/solve/progress.hpp"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

/// The same comparison on every driver of this machine: an implementation of OpenGL or Vulkan that agrees
/// says nothing about the next one.
namespace hdmbench {

/// How a process is made to use another driver than the one installed for it.
struct Implementation {
  std::string name; ///< "softpipe"
  std::vector<std::pair<std::string, std::string>> environment;
};

/// "as installed", what Mesa can be asked for, and every Vulkan driver that has a file where the loader looks
/// (VK_DRIVER_FILES or VK_ICD_FILENAMES, where set, or its folders) or where a browser keeps one. Whether it
/// is there, and for which backends, is not known yet.
[[nodiscard]] std::vector<Implementation> known_implementations();

struct ImplementationOptions {
  std::filesystem::path program;       ///< hdmbench itself
  std::vector<std::string> verify{};   ///< further arguments of `verify`
  std::vector<std::string> backends{}; ///< empty: all but the reference
  double seconds = 0.0;                ///< a process may take
  std::int64_t resident_bytes = 0;     ///< a process may take
  /// Told all rows so far after each implementation; null: nobody is.
  std::function<void(const nlohmann::json& rows)> heard{};
};

/// Asks every implementation for its devices, leaves out those that an earlier one has shown, and runs
/// `verify` on each of the others, every time in a process of its own: a driver that hangs or crashes is a
/// row. Returns the rows of `implementations`' results, a backend on a device of an implementation each:
/// "outcome" is passed, failed, absent, out of time, out of memory, crashed or refused, "tier" the lowest of
/// its comparisons, "reason" why it did not pass, "repeat" a command line for a shell. Throws InputError
/// where the program cannot be started.
[[nodiscard]] nlohmann::json verify_implementations(const std::vector<Implementation>& implementations,
                                                    const ImplementationOptions& options, Progress& progress);

} // namespace hdmbench
