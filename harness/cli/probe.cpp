#include "harness/check/probe.hpp"

#include "harness/cli/gates.hpp"

namespace hdmbench::commands {

namespace {

struct Arguments : CommonArguments {
  Gates gates{};
};

int run_probe(Arguments& arguments, Call& call) {
  arguments.gates.prepare(arguments, call);
  const auto registry = make_backends();
  std::string expected;
  json results = json::array();
  json answers = json::array();
  Progress progress;
  for (const Backend* backend : arguments.choose(registry)) {
    progress.describe(std::string(backend->name()));
    try {
      const std::vector<ProbeRow> rows = probe(*backend, arguments.session);
      for (const ProbeRow& row : rows) {
        results.push_back(to_json_row(row));
        answers.push_back(results.back());
        answers.back()["answer"] = answer_text(row);
      }
      expected += fmt::format("  {}: {}\n", backend->name(), expected_tier(rows));
    } catch (const DeviceError& error) {
      if (arguments.needs(backend->name())) {
        throw;
      }
      expected += fmt::format("  {}: skipped: {}\n", backend->name(), error.what());
    }
  }
  progress.clear();
  if (results.empty()) { // scalar is always there: it is the device that is not
    throw InputError(
        fmt::format("no backend has a device \"{}\"; hdmbench devices lists them", arguments.session.device));
  }
  fmt::print("{}\nExpected of verify\n{}",
             table_text(answers, "backend|device|program|question|answer|telling:could tell"), expected);
  call.write(std::move(results));
  return arguments.gates.judge(success, call);
}

} // namespace

void add_probe(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "probe",
      "What does each device's arithmetic do? Are products fused into sums, are sums reordered,\n"
      "are subnormal numbers, -0, NaN and infinity kept, how are quotients and roots rounded, when does a\n"
      "loop end? One sweep in the very programs that verify compares, and a small program of its own per\n"
      "language, on numbers that tell the cases apart. \"could tell\" counts the answers that would have "
      "been\n"
      "others.",
      run_probe);
  own.add_backends_to(command);
  own.gates.add_to(command);
  add_json(command, call, "Write the answers to this file");
}

} // namespace hdmbench::commands
