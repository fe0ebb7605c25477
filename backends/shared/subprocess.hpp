#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hdmbench {

/// How a program ended.
struct ProcessEnd {
  int exit_status = 0;         ///< 128 + signal where a signal ended it, as a shell has it
  int signal = 0;              ///< 0: it ended by itself
  bool out_of_time = false;    ///< it was killed because it ran too long
  bool out_of_memory = false;  ///< it was killed because it took too much
  double seconds = 0.0;        ///< from start to end
  std::int64_t peak_bytes = 0; ///< the largest resident memory

  [[nodiscard]] bool good() const { return exit_status == 0; }
  /// "exit status 2" or "signal 11"
  [[nodiscard]] std::string text() const;
};

struct ProcessOptions {
  std::string advice{}; ///< the end of the message where the program cannot be started
  std::vector<std::pair<std::string, std::string>> environment{}; ///< in place of, or beside, our own
  std::optional<double> seconds{};                                ///< after which it is killed
  std::optional<std::int64_t> resident_bytes{}; ///< above which it is killed, as seen every 2 ms; needs /proc
};

/// Runs a program to its end. `words` are its name, which is looked for on PATH unless it has a slash, and
/// its arguments; its standard input is empty, what it prints goes to the two files, which are overwritten.
/// Throws InputError where it cannot be started.
[[nodiscard]] ProcessEnd run_process(const std::vector<std::string>& words,
                                     const std::filesystem::path& output, const std::filesystem::path& errors,
                                     const ProcessOptions& options = {});

/// The bytes of a file, none where it cannot be read.
[[nodiscard]] std::string file_text(const std::filesystem::path& file);

} // namespace hdmbench
