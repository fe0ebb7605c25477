#include "harness/check/probe.hpp"

#include "harness/cli/gates.hpp"

namespace hdmbench::commands {

namespace {

void run_probe(const CommonArguments& arguments, const std::string& line) {
  require_results_writable(arguments.json);
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
  write_results(arguments.json, "probe", run_context(line, false), std::move(results));
}

} // namespace

void add_probe(CLI::App& program, Call& call) {
  CLI::App* const command = program.add_subcommand(
      "probe",
      "What does each device's arithmetic do? Are products fused into sums, are sums reordered, are "
      "subnormal\n"
      "numbers, -0, NaN and infinity kept, how are quotients and roots rounded, when does a loop end? One\n"
      "sweep in the very programs that verify compares, and a small program of its own per language, on\n"
      "numbers that tell the cases apart. \"could tell\" counts the answers that would have been others.");
  const auto own = std::make_shared<CommonArguments>();
  own->add_backends_to(*command);
  const auto gates = std::make_shared<Gates>();
  gates->add_to(*command);
  add_option(*command, "--json", own->json, "Write the answers to this file");
  command->callback([own, gates, &call] {
    gates->prepare(*own);
    run_probe(*own, call.line);
    call.status = gates->judge(success, *own);
  });
}

} // namespace hdmbench::commands
