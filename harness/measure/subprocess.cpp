#include "harness/measure/subprocess.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>

#include <fcntl.h>
#include <spawn.h>
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

} // namespace

std::string ProcessEnd::text() const {
  return signal != 0 ? fmt::format("signal {}", signal) : fmt::format("exit status {}", exit_status);
}

ProcessEnd run_process(const std::vector<std::string>& words, const std::filesystem::path& output,
                       const std::filesystem::path& errors, const std::string& advice) {
  FileActions actions;
  actions.redirect(STDIN_FILENO, "/dev/null", O_RDONLY);
  actions.redirect(STDOUT_FILENO, output.string(), O_WRONLY | O_CREAT | O_TRUNC);
  actions.redirect(STDERR_FILENO, errors.string(), O_WRONLY | O_CREAT | O_TRUNC);

  std::vector<std::string> writable = words;
  std::vector<char*> arguments;
  std::ranges::transform(writable, std::back_inserter(arguments),
                         [](std::string& word) { return word.data(); });
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int failed =
      posix_spawnp(&child, words.front().c_str(), actions.get(), nullptr, arguments.data(), environ);
  if (failed != 0) {
    throw InputError(fmt::format("{} cannot be started: {}{}{}", words.front(), error_text(failed),
                                 advice.empty() ? "" : ". ", advice));
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) {
      throw InputError(fmt::format("{} cannot be waited for: {}", words.front(), error_text(errno)));
    }
  }
  if (WIFSIGNALED(status)) {
    return {128 + WTERMSIG(status), WTERMSIG(status)};
  }
  return {WEXITSTATUS(status), 0};
}

std::string file_text(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

} // namespace hdmbench
