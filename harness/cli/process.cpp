#include "harness/cli/process.hpp"

#include "harness/cli/commands.hpp"
#include "harness/scene/files.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

namespace hdmbench::commands {

namespace {

struct Limit {
  __rlimit_resource resource;
  rlim_t least;
  const char* what;
  const char* option; ///< of ulimit
};

constexpr std::array least_limits{Limit{RLIMIT_NOFILE, 64, "open files", "-n"},
                                  Limit{RLIMIT_STACK, rlim_t{1} << 20, "bytes of stack", "-s"}};

/// What a handler of signals may use: texts that are there before, and write().
struct LastWords {
  bool main_goes_on = true;
  std::array<std::string, 64> of_signals{};
};

LastWords& last_words() {
  static LastWords words;
  return words;
}

constexpr std::array crashes{SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT};

void say(const std::string& words) {
  (void)!write(STDERR_FILENO, words.data(), words.size());
}

extern "C" void end_after_crash(int signal) {
  say(last_words().of_signals.at(static_cast<std::size_t>(signal)));
  _exit(bad_input);
}

extern "C" void end_after_exit() {
  if (std::exchange(last_words().main_goes_on, false)) {
    std::fflush(stdout);
    say("hdmbench: a library has ended the program; its words, if it said any, stand above\n");
    _exit(bad_input);
  }
}

/// What waits for the end of its last character.
struct PrintedStream {
  int descriptor = -1;
  std::string rest{};
};

/// How many of the last bytes may be the beginning of a character of UTF-8.
std::size_t begun_character(std::string_view text) {
  for (std::size_t i = 1; i <= std::min<std::size_t>(text.size(), 3); ++i) {
    const auto byte = static_cast<unsigned char>(text[text.size() - i]);
    if (byte >= 0xC0) {
      return (byte >= 0xF0 ? 4U : byte >= 0xE0 ? 3U : 2U) > i ? i : 0;
    }
    if (byte < 0x80) {
      return 0;
    }
  }
  return 0;
}

/// A write function of fopencookie(): 0 is an error.
ssize_t print_as_text(void* stream, const char* bytes, std::size_t size) {
  auto& to = *static_cast<PrintedStream*>(stream);
  std::string text = std::exchange(to.rest, {}) + std::string(bytes, size);
  to.rest = text.substr(text.size() - begun_character(text));
  text.resize(text.size() - to.rest.size());
  text = printable(text);
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t now = write(to.descriptor, text.data() + done, text.size() - done);
    if (now < 0 && errno != EINTR) {
      return 0;
    }
    done += static_cast<std::size_t>(std::max<ssize_t>(now, 0));
  }
  return static_cast<ssize_t>(size);
}

std::string address_space() {
  rlimit limit{};
  return getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY
             ? fmt::format(
                   "; {:.2f} GB of address space are allowed (ulimit -v), which drivers may need more of",
                   static_cast<double>(limit.rlim_cur) * 1e-9)
             : "";
}

} // namespace

void require_limits() {
  for (const Limit& one : least_limits) {
    rlimit limit{};
    if (getrlimit(one.resource, &limit) == 0 && limit.rlim_cur < one.least) {
      throw InputError(fmt::format("{} {} are allowed (ulimit {}), {} are needed", limit.rlim_cur, one.what,
                                   one.option, one.least));
    }
  }
}

void explain_sudden_end() {
  if (std::getenv("HDMBENCH_ASK_IN_PROCESS") != nullptr) {
    return;
  }
  LastWords& words = last_words(); // before atexit(), so that it is there when that is called
  std::atexit(end_after_exit);
  static std::array<char, 1U << 16U> stack; // that of the thread may be what has ended
  const stack_t own{.ss_sp = stack.data(), .ss_flags = 0, .ss_size = stack.size()};
  sigaltstack(&own, nullptr);
  for (const int signal : crashes) {
    words.of_signals.at(static_cast<std::size_t>(signal)) =
        fmt::format("\nhdmbench: ended by signal {} ({}), in a library or a driver{}. What --json FILE has "
                    "so far is kept; "
                    "hdmbench devices names the drivers, --backends leaves some out\n",
                    signal, strsignal(signal), address_space());
    struct sigaction action {};
    if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_DFL) { // no sanitizer has it
      action.sa_handler = end_after_crash;
      action.sa_flags = SA_ONSTACK | static_cast<int>(SA_RESETHAND);
      sigaction(signal, &action, nullptr);
    }
  }
}

void print_printable() {
  static PrintedStream stream;
  stream.descriptor = fileno(stdout);
  std::fflush(stdout);
  if (std::FILE* const text = fopencookie(
          &stream, "w", {.read = nullptr, .write = print_as_text, .seek = nullptr, .close = nullptr})) {
    std::setvbuf(text, nullptr, isatty(stream.descriptor) != 0 ? _IOLBF : _IOFBF, BUFSIZ);
    stdout = text;
  }
}

int ended_by_main(int status) {
  last_words().main_goes_on = false;
  return status;
}

} // namespace hdmbench::commands
