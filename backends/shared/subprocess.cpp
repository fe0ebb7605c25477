#include "backends/shared/subprocess.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hdmbench {

namespace {

std::string error_text(int code) {
  return std::generic_category().message(code);
}

class FileActions {
public:
  FileActions() { check(posix_spawn_file_actions_init(&actions_)); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }

  void redirect(int descriptor, const std::string& file, int flags) {
    check(posix_spawn_file_actions_addopen(&actions_, descriptor, file.c_str(), flags, 0600));
  }
  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

private:
  static void check(int code) {
    if (code != 0) {
      throw InputError(fmt::format("a program cannot be prepared: {}", error_text(code)));
    }
  }

  posix_spawn_file_actions_t actions_{};
};

/// Our environment with these in place of what it has by their names, as "NAME=value".
std::vector<std::string> environment_with(const std::vector<std::pair<std::string, std::string>>& changes) {
  std::vector<std::string> variables;
  for (char** own = environ; *own != nullptr; ++own) {
    const std::string_view variable = *own;
    const bool changed = std::ranges::any_of(
        changes, [&](const auto& change) { return variable.starts_with(change.first + "="); });
    if (!changed) {
      variables.emplace_back(variable);
    }
  }
  for (const auto& [name, value] : changes) {
    variables.push_back(fmt::format("{}={}", name, value));
  }
  return variables;
}

/// As the system's calls want them: with a null pointer at the end.
std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  std::ranges::transform(texts, std::back_inserter(all), [](std::string& text) { return text.data(); });
  all.push_back(nullptr);
  return all;
}

/// 0 where there is no /proc.
std::int64_t resident_bytes_of(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/statm", process));
  std::int64_t total = 0;
  std::int64_t resident = 0; // pages
  return file >> total >> resident ? resident * sysconf(_SC_PAGESIZE) : 0;
}

} // namespace

std::string ProcessEnd::text() const {
  return signal != 0 ? fmt::format("signal {}", signal) : fmt::format("exit status {}", exit_status);
}

std::string ProcessEnd::sentence(const ProcessOptions& options) const {
  return out_of_time     ? fmt::format("gave no answer within {:g} s", options.seconds.value_or(0.0))
         : out_of_memory ? fmt::format("took more than {:g} GB",
                                       static_cast<double>(options.resident_bytes.value_or(0)) * 1e-9)
         : signal != 0   ? fmt::format("was ended by signal {} ({})", signal, strsignal(signal))
                         : fmt::format("ended the process with status {}", exit_status);
}

ProcessEnd run_process(const std::vector<std::string>& words, const std::filesystem::path& output,
                       const std::filesystem::path& errors, const ProcessOptions& options) {
  FileActions actions;
  actions.redirect(STDIN_FILENO, "/dev/null", O_RDONLY);
  actions.redirect(STDOUT_FILENO, output.string(), O_WRONLY | O_CREAT | O_TRUNC);
  actions.redirect(STDERR_FILENO, errors.string(), O_WRONLY | O_CREAT | O_TRUNC);

  std::vector<std::string> writable = words;
  std::vector<std::string> variables = environment_with(options.environment);
  const auto began = std::chrono::steady_clock::now();
  pid_t child = 0;
  const int failed = posix_spawnp(&child, words.front().c_str(), actions.get(), nullptr,
                                  pointers(writable).data(), pointers(variables).data());
  if (failed != 0) {
    throw InputError(fmt::format("{} cannot be started: {}{}{}", words.front(), error_text(failed),
                                 options.advice.empty() ? "" : ". ", options.advice));
  }
  const bool watched = options.seconds || options.resident_bytes;
  ProcessEnd end;
  int status = 0;
  rusage usage{};
  for (pid_t ended = 0; ended == 0;) {
    ended = wait4(child, &status, watched ? WNOHANG : 0, &usage);
    if (ended < 0 && errno != EINTR) {
      throw InputError(fmt::format("{} cannot be waited for: {}", words.front(), error_text(errno)));
    }
    ended = std::max(ended, 0);
    end.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    if (ended == 0 && watched) {
      end.out_of_time = end.out_of_time || end.seconds > options.seconds.value_or(end.seconds);
      end.out_of_memory =
          end.out_of_memory || (options.resident_bytes && resident_bytes_of(child) > *options.resident_bytes);
      if (end.out_of_time || end.out_of_memory) {
        kill(child, SIGKILL);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  end.peak_bytes = static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
  end.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  end.exit_status = end.signal != 0 ? 128 + end.signal : WEXITSTATUS(status);
  return end;
}

MemoryFile::MemoryFile() : descriptor_(memfd_create("hdmbench", 0)) {}

MemoryFile::~MemoryFile() {
  close(descriptor_);
}

std::string MemoryFile::path() const {
  return fmt::format("/proc/self/fd/{}", descriptor_);
}

ProcessEnd ask_own_program(std::string_view question, std::string_view subject,
                           const std::filesystem::path& output, const std::filesystem::path& errors,
                           const ProcessOptions& options) {
  return run_process(
      {"/proc/self/exe", std::string(question), std::string(subject), std::to_string(getpid())}, output,
      errors, options);
}

std::optional<std::string> asked_subject(int argc, const char* const* argv, std::string_view question) {
  if (argc != 4 || argv[1] != question) {
    return std::nullopt;
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL); // nobody else would end a process that hangs
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  if (std::to_string(getppid()) != argv[3]) {
    std::_Exit(EXIT_FAILURE);
  }
  return argv[2];
}

std::string file_text(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

} // namespace hdmbench
