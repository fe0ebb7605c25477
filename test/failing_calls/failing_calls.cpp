// failing_calls: every call of a driver fails once, see faults.hpp. The stand-ins are found
// by the program's run path.

#include "backends/registry.hpp"
#include "harness/check/failing_calls_row.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/solve/progress.hpp"
#include "kernels/data/input_error.hpp"
#include "test/failing_calls/trial.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

namespace hdmbench::failing_calls {
namespace {

using nlohmann::json;

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

/// All runs of one kind on one backend.
struct Row : FailingCallsRow {
  const Kind* own_kind = nullptr;
  bool absent = false; ///< the backend is not there; `unclean` is empty and `reason` says why
  std::string reason{};
};

// The child, a process per kind: what crashes or hangs takes nothing else along. Its standard output is a
// line of JSON per event; whatever a driver prints there is a complaint.

void say(const json& line) {
  fmt::print("{}\n", line.dump());
  std::fflush(stdout);
}

void run_child(const std::string& backend, const Kind& kind, int first, int stride) {
  const auto backends = make_backends();
  const Backend& subject = find_backend(backends, backend);
  alarm(seconds_until_hung);
  try {
    static_cast<void>(subject.devices());
  } catch (const DeviceError& error) {
    say({{"absent", error.what()}});
    return;
  }
  Trial trial(subject);
  const int calls = trial.calls(kind);
  say({{"calls", calls}});
  for (int at = first; at <= calls; at += stride) {
    say({{"at", at}});
    alarm(seconds_until_hung);
    Outcome outcome = trial.run(kind, at);
    if (outcome.went_on && at + stride > calls) { // no further trial opens a session
      if (const std::string wrong = trial.wrong_with_next(); !wrong.empty()) {
        outcome.ending = Ending::unclean;
        outcome.what = wrong;
      }
    }
    say({{"ending", static_cast<int>(outcome.ending)},
         {"went_on", outcome.went_on},
         {"call", outcome.call},
         {"what", outcome.what}});
  }
}

// The parent.

std::string end_of(int status) {
  if (WIFSIGNALED(status)) {
    return WTERMSIG(status) == SIGALRM ? "hung" : fmt::format("crashed: {}", strsignal(WTERMSIG(status)));
  }
  return fmt::format("ended with status {}", WEXITSTATUS(status));
}

/// Runs a child from the `first` call on. Returns the call from which another child has to go on, 0: all
/// done.
int watch_child(const std::string& program, Row& row, int first, int stride, bool verbose) {
  const std::string command =
      fmt::format("exec '{}' --child '{}' --kind '{}/{}' --first {} --every {}", program, row.backend,
                  row.own_kind->api, row.own_kind->name, first, stride);
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) {
    throw std::runtime_error("popen failed");
  }
  int at = 0;
  bool running = false; // the `at`-th call's run
  char* text = nullptr;
  std::size_t room = 0;
  for (ssize_t length = 0; (length = getline(&text, &room, pipe)) > 0;) {
    const json line = json::parse(std::string_view(text, static_cast<std::size_t>(length)), nullptr, false);
    if (!line.is_object()) {
      row.unclean.push_back(fmt::format("{}: printed {}", at, text));
    } else if (line.contains("absent")) {
      row.absent = true;
      row.reason = line["absent"];
    } else if (line.contains("calls")) {
      row.calls = line["calls"];
    } else if (line.contains("at")) {
      at = line["at"];
      running = true;
    } else {
      running = false;
      const std::string told =
          fmt::format("{} {}: {}", at, line["call"].get<std::string>(), line["what"].get<std::string>());
      if (verbose) {
        fmt::print("{} {}\n", row.own_kind->name, told);
      }
      row.went_on += line["went_on"].get<bool>() ? 1 : 0;
      switch (static_cast<Ending>(line["ending"].get<int>())) {
      case Ending::clean:
        ++row.clean;
        break;
      case Ending::succeeded:
        ++row.succeeded;
        break;
      case Ending::unclean:
        row.unclean.push_back(told);
      }
    }
  }
  std::free(text);
  const int status = pclose(pipe);
  if (status != 0) {
    row.unclean.push_back(fmt::format("{}: {}", at, end_of(status)));
  }
  row.failed = row.clean + row.succeeded + std::ssize(row.unclean);
  return running ? at + stride : 0;
}

std::vector<Row> rows_of(const std::vector<std::string>& wanted) {
  std::vector<Row> rows;
  for (const Subject& subject : subjects()) {
    if (!wanted.empty() && std::ranges::find(wanted, subject.backend) == wanted.end()) {
      continue;
    }
    for (const std::string_view api : subject.apis) {
      for (const Kind& kind : kinds()) {
        if (kind.api == api) {
          rows.push_back({{subject.backend, std::string(kind.api), std::string(kind.name)}, &kind});
        }
      }
    }
  }
  return rows;
}

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

/// Several rows at a time, a thread each that only waits for its child.
void fill(std::vector<Row>& rows, bool quick, bool verbose) {
  std::array<char, 4096> buffer{};
  const ssize_t length = readlink("/proc/self/exe", buffer.data(), buffer.size());
  const std::string program(buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
  Progress progress;
  progress.set_total(static_cast<double>(rows.size()));
  std::mutex mutex;
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < rows.size(); i = next++) {
      {
        const std::lock_guard lock(mutex);
        progress.describe(fmt::format("{}: {}", rows[i].backend, rows[i].own_kind->name));
      }
      auto [first, stride] = quick ? turn_of(*rows[i].own_kind) : Turn{};
      while (first > 0) {
        first = watch_child(program, rows[i], first, stride, verbose);
      }
      const std::lock_guard lock(mutex);
      progress.advance(1.0);
    }
  };
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i) {
    threads.emplace_back(work);
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
}

void print(const std::vector<Row>& rows) {
  Table table({"<backend", "<API", "<what happens", "calls", "failed", "clean errors", "succeeded anyway",
               "not clean", "session went on"});
  std::string unclean;
  for (const Row& row : rows) {
    if (row.absent) {
      table.add({row.backend, row.api, row.kind, "not there", "", "", "", "", ""});
      continue;
    }
    table.add({row.backend, row.api, row.kind, std::to_string(row.calls), std::to_string(row.failed),
               std::to_string(row.clean), std::to_string(row.succeeded), std::to_string(row.unclean.size()),
               std::to_string(row.went_on)});
    for (const std::string& what : row.unclean) {
      unclean += fmt::format("  {}, {} {}, call {}\n", row.backend, row.api, row.kind, what);
    }
  }
  fmt::print("{}", table.text());
  if (!unclean.empty()) {
    fmt::print("\nNot clean:\n{}", unclean);
  }
}

json to_json(const std::vector<Row>& rows) {
  json all = json::array();
  for (const Row& row : rows) {
    if (!row.absent) {
      all.push_back(to_json_row<FailingCallsRow>(row));
    }
  }
  return all;
}

int run(int argc, char** argv) {
  CLI::App program(
      "failing_calls: every call of a graphics driver fails once, in every way it can, while a backend "
      "works on two small levels and a pyramid.\nExit status 1 unless each time there was an error that "
      "names the "
      "call and the reason, nothing was left behind,\nand the same session went on to the right bits, or the "
      "next one did.");
  std::vector<std::string> backends;
  std::filesystem::path file;
  bool quick = false;
  int stride = 1;
  bool verbose = false;
  std::string child;
  std::string kind;
  int first = 1;
  program.add_option("--backends", backends, "Only these")->delimiter(',');
  program.add_flag("--quick", quick, "Every call fails in one of the ways instead of in all of them");
  program.add_option("--json", file, "Write the results to this file");
  program.add_flag("--verbose", verbose, "Print every message");
  const std::string hidden;
  program.add_option("--child", child)->group(hidden);
  program.add_option("--kind", kind)->group(hidden);
  program.add_option("--first", first)->group(hidden);
  program.add_option("--every", stride)->group(hidden);
  CLI11_PARSE(program, argc, argv);
  if (!child.empty()) {
    const auto slash = kind.find('/');
    run_child(child, kind_of(kind.substr(0, slash), kind.substr(slash + 1)), first, stride);
    return 0;
  }
  require_results_writable(file);
  std::vector<Row> rows = rows_of(backends);
  fill(rows, quick, verbose);
  print(rows);
  write_results(file, "failing-calls", run_context(quick ? "failing_calls --quick" : "failing_calls", quick),
                to_json(rows));
  if (std::ranges::all_of(rows, &Row::absent)) {
    fmt::print("\nNone of the backends is there: {}\n", rows.front().reason);
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
