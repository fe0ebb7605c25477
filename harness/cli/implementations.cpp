#include "harness/measure/implementations.hpp"

#include "harness/cli/arguments.hpp"

#include <fmt/ranges.h>

#include <map>

namespace hdmbench::commands {

namespace {

struct Arguments {
  CommonArguments verify;
  double seconds = 180.0;
  double gigabytes = 2.0;
};

/// What was given of the arguments that `verify` has too, for another process: scenes first.
std::vector<std::string> verify_words(const CLI::App& command, std::vector<std::string> words) {
  for (const CLI::Option* const option : command.get_options()) {
    const std::string name = option->get_name();
    const bool is_own = name == "--json" || name == "--backends" || name.starts_with("--limit");
    if (option->count() > 0 && !option->get_positional() && !is_own) {
      words.push_back(name);
      if (option->get_items_expected_max() > 0) {
        words.push_back(fmt::format("{}", fmt::join(option->results(), ",")));
      }
    }
  }
  return words;
}

int run_implementations(Arguments& arguments, Call& call) {
  const auto registry = make_backends();
  for (const std::string& name : arguments.verify.backends) {
    (void)find_backend(registry, name);
  }
  Progress progress;
  json rows = verify_implementations(known_implementations(),
                                     {.program = std::filesystem::read_symlink("/proc/self/exe"),
                                      .verify = verify_words(*call.command, arguments.verify.scenes),
                                      .backends = arguments.verify.backends,
                                      .seconds = arguments.seconds,
                                      .resident_bytes = static_cast<std::int64_t>(arguments.gigabytes * 1e9)},
                                     progress);
  progress.clear();
  fmt::print("{}",
             table_text(rows, "backend|implementation|device|outcome|tier|scenes|comparisons|sites_compared|"
                              "sites_differing:differing|seconds|peak_bytes:bytes"));
  std::map<std::string, std::ptrdiff_t> count; // by outcome
  for (const json& row : rows) {
    ++count[row["outcome"]];
    const auto word = [&](const char* key) { return row[key].get<std::string>(); };
    if (row["reason"] != "") {
      fmt::print("\n  {} on {}: {}\n", word("backend"), word("implementation"), word("reason"));
      if (row["repeat"] != "") {
        fmt::print("    repeat: {}\n", word("repeat"));
      }
    }
  }
  const auto passed = count["passed"];
  const auto failed = std::ssize(rows) - passed - count["absent"];
  fmt::print("\n{} pass, {} do not, {} are not there\n", passed, failed, count["absent"]);
  call.write(std::move(rows), arguments.verify.quick);
  return failed > 0 || passed == 0 ? disagreement : success;
}

} // namespace

void add_implementations(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "implementations",
      "Run verify on every implementation of OpenGL and Vulkan that this machine has, each in a process of\n"
      "its own: as installed, Mesa's llvmpipe and softpipe, every Vulkan driver with a file, and zink on "
      "it.\n"
      "A driver that hangs, crashes or takes too much memory is a row of the table.\n"
      "Takes the arguments of verify. Exit status 1 if one does not pass.",
      run_implementations);
  own.verify.add_to(command, call);
  remove_options(command, {"--device", "--require"});
  add_option(command, "--limit-seconds", own.seconds, "That one implementation of one backend may take")
      ->check(CLI::Range(1.0, 1e6));
  add_option(command, "--limit-memory", own.gigabytes, "That it may take, in GB")
      ->check(CLI::Range(0.1, 1e4));
}

} // namespace hdmbench::commands
