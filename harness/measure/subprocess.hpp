#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hdmbench {

/// How a program ended.
struct ProcessEnd {
  int exit_status = 0; ///< 128 + signal where a signal ended it, as a shell has it
  int signal = 0;      ///< 0: it ended by itself

  [[nodiscard]] bool good() const { return exit_status == 0; }
  /// "exit status 2" or "signal 11"
  [[nodiscard]] std::string text() const;
};

/// Runs a program to its end. `words` are its name, which is looked for on PATH unless it has a slash, and
/// its arguments; its standard input is empty, what it prints goes to the two files, which are overwritten.
/// Throws InputError where it cannot be started, with `advice` at the end.
[[nodiscard]] ProcessEnd run_process(const std::vector<std::string>& words,
                                     const std::filesystem::path& output, const std::filesystem::path& errors,
                                     const std::string& advice = {});

/// The bytes of a file, none where it cannot be read.
[[nodiscard]] std::string file_text(const std::filesystem::path& file);

} // namespace hdmbench
