// failing_calls: every call of a driver fails once, see faults.hpp. The stand-ins are found
// by the program's run path.

#include "backends/registry.hpp"
#include "backends/shared/subprocess.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/solve/progress.hpp"
#include "kernels/data/input_error.hpp"
#include "test/captured_stream.hpp"
#include "test/failing_calls/trial.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>

#include <unistd.h>

namespace hdmbench::failing_calls {
namespace {

constexpr int nothing_to_test = 77;         // exit status
constexpr unsigned seconds_until_hung = 60; // a run takes well below one

/// The APIs that a backend goes through.
struct Subject {
  const char* backend;
  std::vector<std::string_view> apis;
};

const std::array<Subject, 5>& subjects() {
  static const std::array<Subject, 5> all{{{"gl-fragment", {"EGL", "OpenGL"}},
                                           {"gl-fragment-osmesa", {"OSMesa", "OpenGL"}},
                                           {"gl-compute", {"EGL", "OpenGL"}},
                                           {"vulkan-compute", {"Vulkan"}},
                                           {"opencl", {"OpenCL"}}}};
  return all;
}

/// What is running, for the handler of a signal that ends the program.
std::array<char, 200>& running() {
  static std::array<char, 200> words{};
  return words;
}

void say_what_ended(int signal) {
  const auto say = [](const char* words) { (void)!write(STDERR_FILENO, words, std::strlen(words)); };
  say("failing_calls: ");
  say(running().data());
  say(signal == SIGALRM ? ": the program hung\n" : ": the program crashed\n");
  _exit(1);
}

/// What is written to the file: all runs of one kind on one backend.
struct Row {
  std::string backend;
  std::string api;            ///< "OpenGL"
  std::string kind;           ///< "GL_OUT_OF_MEMORY"
  std::int64_t calls = 0;     ///< of a run, that can fail so
  std::int64_t failed = 0;    ///< of them, a run each
  std::int64_t clean = 0;     ///< said the call and the reason, left nothing behind
  std::int64_t succeeded = 0; ///< right bits without the call
  std::int64_t went_on = 0;   ///< of the clean ones: the same session computed the right bits afterwards
  std::vector<std::string> unclean{}; ///< all others, in words
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Row, backend, api, kind, calls, failed, clean, succeeded, went_on, unclean)

/// Which calls a kind befalls: first, first + stride, ...
struct Turn {
  int first = 1;
  int stride = 1;
};

/// Kinds that befall the same calls take turns, so that between them every call fails once.
Turn turn_of(const Kind& kind) {
  Turn turn{.first = 1, .stride = 0};
  for (const Kind& other : kinds()) {
    if (other.api == kind.api && other.event == kind.event) {
      ++turn.stride;
      turn.first += &other < &kind ? 1 : 0;
    }
  }
  return turn;
}

/// All runs of one kind on one backend.
Row row_of(Trial& trial, const std::string& backend, const Kind& kind, Turn turn) {
  test::CapturedStream printed(stdout); // by drivers and the validation layers of Vulkan
  Row row{.backend = backend,
          .api = std::string(kind.api),
          .kind = std::string(kind.name),
          .calls = trial.calls(kind)};
  for (std::int64_t at = turn.first; at <= row.calls; at += turn.stride) {
    fmt::format_to_n(running().data(), running().size() - 1, "{}, {} {}, call {}{}", backend, kind.api,
                     kind.name, at, '\0');
    alarm(seconds_until_hung);
    Outcome outcome = trial.run(kind, static_cast<int>(at));
    std::string wrong = printed.take();
    if (wrong.empty() && outcome.went_on &&
        at + turn.stride > row.calls) { // no further trial opens a session
      wrong = trial.wrong_with_next();
    }
    if (!wrong.empty()) {
      outcome.ending = Ending::unclean;
      outcome.what = wrong;
    }
    row.went_on += outcome.went_on ? 1 : 0;
    row.clean += outcome.ending == Ending::clean ? 1 : 0;
    row.succeeded += outcome.ending == Ending::succeeded ? 1 : 0;
    if (outcome.ending == Ending::unclean) {
      row.unclean.push_back(fmt::format("{} {}: {}", at, outcome.call, outcome.what));
    }
  }
  alarm(0);
  row.failed = row.clean + row.succeeded + std::ssize(row.unclean);
  return row;
}

std::vector<Row> rows_of(const Backend& backend, const Subject& subject, bool quick) {
  Trial trial(backend);
  std::vector<Row> rows;
  Progress progress;
  for (const Kind& kind : kinds()) {
    if (std::ranges::find(subject.apis, kind.api) != subject.apis.end()) {
      progress.describe(fmt::format("{}: {}", subject.backend, kind.name));
      rows.push_back(row_of(trial, subject.backend, kind, quick ? turn_of(kind) : Turn{}));
    }
  }
  return rows;
}

void print(const std::vector<Row>& rows) {
  nlohmann::json table = nlohmann::json::array();
  std::string unclean;
  for (const Row& row : rows) {
    table.push_back({{"backend", row.backend},
                     {"API", row.api},
                     {"kind", row.kind},
                     {"calls", row.calls},
                     {"failed", row.failed},
                     {"clean", row.clean},
                     {"succeeded", row.succeeded},
                     {"not_clean", row.unclean.size()},
                     {"went_on", row.went_on}});
    for (const std::string& what : row.unclean) {
      unclean += fmt::format("  {}, {} {}, call {}\n", row.backend, row.api, row.kind, what);
    }
  }
  fmt::print("{}{}{}",
             table_text(table, "backend|API|kind:what happens|calls|failed|clean:clean errors|"
                               "succeeded:succeeded anyway|not_clean|went_on:session went on"),
             unclean.empty() ? "" : "\nNot clean:\n", unclean);
}

int run(int argc, char** argv) {
  CLI::App program(
      "failing_calls: every call of a graphics driver fails once, in every way it can, while a backend "
      "works on two small levels and a pyramid.\nExit status 1 unless each time there was an error that "
      "names the call and the reason, nothing was left behind,\nand the same session went on to the right "
      "bits, or the next one did.");
  std::vector<std::string> wanted;
  std::filesystem::path file;
  bool quick = false;
  program.add_option("--backends", wanted, "Only these")->delimiter(',');
  program.add_flag("--quick", quick, "Every call fails in one of the ways instead of in all of them");
  program.add_option("--json", file, "Write the results to this file");
  CLI11_PARSE(program, argc, argv);
  require_results_writable(file);
  for (const int signal : {SIGABRT, SIGALRM, SIGBUS, SIGFPE, SIGILL, SIGSEGV}) {
    std::signal(signal, say_what_ended);
  }
  const auto backends = make_backends();
  std::vector<Row> rows;
  for (const Subject& subject : subjects()) {
    if (!wanted.empty() && std::ranges::find(wanted, subject.backend) == wanted.end()) {
      continue;
    }
    const Backend& backend = find_backend(backends, subject.backend);
    alarm(seconds_until_hung);
    try {
      (void)backend.devices();
    } catch (const DeviceError& error) {
      fmt::print("{} is not there: {}\n", subject.backend, error.what());
      continue;
    }
    std::ranges::move(rows_of(backend, subject, quick), std::back_inserter(rows));
  }
  print(rows);
  write_results(file, "failing-calls", run_context(quick ? "failing_calls --quick" : "failing_calls", quick),
                rows);
  if (rows.empty()) {
    return nothing_to_test;
  }
  return std::ranges::all_of(rows, [](const Row& row) { return row.unclean.empty(); }) ? 0 : 1;
}

} // namespace
} // namespace hdmbench::failing_calls

int main(int argc, char** argv) {
  try {
    return hdmbench::failing_calls::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "failing_calls: {}\n", error.what());
    return 2;
  }
}
