#include "backends/shared/driver_trial.hpp"

#include "backends/backend.hpp"
#include "backends/shared/subprocess.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <map>
#include <mutex>
#include <sstream>

namespace hdmbench {

namespace {

constexpr std::string_view question = "--ask-driver-of";
constexpr int answered = 78; // exit status: a driver that ends the process by itself takes another one

std::atomic<bool>& tries_drivers() {
  static std::atomic<bool> tries = false;
  return tries;
}

/// The last line that is not empty, of characters that any file of results can take.
std::string last_line(const std::string& text) {
  constexpr std::size_t most = 200;
  std::string last;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    last = line.empty() ? last : line.substr(0, most);
  }
  std::ranges::replace_if(
      last, [](char c) { return c < ' ' || c > '~'; }, '?');
  return last;
}

} // namespace

void begin_driver_trials(int argc, const char* const* argv,
                         const std::function<void(std::string_view backend)>& ask) {
  if (const auto backend = asked_subject(argc, argv, question)) {
    ask(*backend);
    std::_Exit(answered);
  }
  tries_drivers() = std::getenv("HDMBENCH_ASK_IN_PROCESS") == nullptr;
}

std::string try_driver(const std::string& backend, const TrialLimits& limits) {
  const MemoryFile said;
  const ProcessOptions options{.seconds = limits.seconds, .resident_bytes = limits.resident_bytes};
  ProcessEnd end;
  try {
    end = ask_own_program(question, backend, "/dev/null", said.path(), options);
  } catch (const InputError&) {
    return {};
  }
  if (end.exit_status == answered) {
    return {};
  }
  const std::string words = last_line(file_text(said.path()));
  return fmt::format("the driver {} when it was asked for its devices in a process of its own{}",
                     end.sentence(options),
                     words.empty() ? "" : fmt::format("; its last words were: {}", words));
}

void require_answer(std::string_view backend) {
  if (!tries_drivers()) {
    return;
  }
  static std::mutex trying;
  static std::map<std::string, std::string, std::less<>> tried; // what try_driver() said, by backend
  const std::lock_guard guard(trying);
  const auto [found, is_new] = tried.try_emplace(std::string(backend));
  if (is_new) {
    found->second = try_driver(found->first);
  }
  if (!found->second.empty()) {
    throw DeviceError(found->second);
  }
}

} // namespace hdmbench
