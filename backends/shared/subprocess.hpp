#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hdmbench {

struct ProcessOptions {
  std::string advice{}; ///< the end of the message where the program cannot be started
  std::vector<std::pair<std::string, std::string>> environment{}; ///< in place of, or beside, our own
  std::optional<double> seconds{};                                ///< after which it is killed
  std::optional<std::int64_t> resident_bytes{}; ///< above which it is killed, as seen every 2 ms; needs /proc
};

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
  /// The rest of a sentence about a program that ran under these options and did not do what it should:
  /// "was ended by signal 11 (Segmentation fault)"
  [[nodiscard]] std::string sentence(const ProcessOptions& options) const;
};

/// Runs a program to its end. `words` are its name, which is looked for on PATH unless it has a slash, and
/// its arguments; its standard input is empty, what it prints goes to the two files, which are overwritten.
/// Throws InputError where it cannot be started.
[[nodiscard]] ProcessEnd run_process(const std::vector<std::string>& words,
                                     const std::filesystem::path& output, const std::filesystem::path& errors,
                                     const ProcessOptions& options = {});

/// A file in memory, for what a process prints: a pipe would block one that prints more than it holds.
class MemoryFile {
public:
  MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile();

  /// For this process and those that inherit its descriptors.
  [[nodiscard]] std::string path() const;

private:
  int descriptor_;
};

/// Starts this program again, to ask it what may crash, hang or take all memory; as run_process() does. It is
/// spawned and not forked, because a fork after a driver, OpenMP or MPI has started threads may hang.
[[nodiscard]] ProcessEnd ask_own_program(std::string_view question, std::string_view subject,
                                         const std::filesystem::path& output,
                                         const std::filesystem::path& errors, const ProcessOptions& options);

/// In a process that ask_own_program() has started with this question: its subject. The process then ends
/// with the one that asks, and leaves no core file. Nothing in every other process.
[[nodiscard]] std::optional<std::string> asked_subject(int argc, const char* const* argv,
                                                       std::string_view question);

/// The bytes of a file, none where it cannot be read.
[[nodiscard]] std::string file_text(const std::filesystem::path& file);

} // namespace hdmbench
