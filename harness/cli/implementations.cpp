#include "harness/measure/implementations.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/grouped.hpp"
#include "harness/report/table.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace hdmbench::commands {

namespace {

struct Arguments {
  CommonArguments verify;
  double seconds = 180.0;
  double gigabytes = 2.0;
};

/// What was given of the arguments that `verify` has too, for another process.
std::vector<std::string> verify_words(const Command& command) {
  std::vector<std::string> words;
  std::vector<std::string> scenes;
  for (const Option& option : command.options()) {
    const std::string name = option.name();
    if (option.count() == 0 || name == "--json" || name == "--backends" || name.starts_with("--limit")) {
      continue;
    }
    if (option.is_positional()) {
      scenes = option.values();
      continue;
    }
    words.push_back(name);
    if (option.takes_values()) {
      words.push_back(fmt::format("{}", fmt::join(option.values(), ",")));
    }
  }
  words.insert(words.begin(), scenes.begin(), scenes.end());
  return words;
}

std::string verdict(const ImplementationRow& row) {
  return row.outcome == Outcome::passed ? std::string(name_of(row.tier)) : std::string(name_of(row.outcome));
}

void print_matrix(const std::vector<ImplementationRow>& rows) {
  Table table({"<backend", "<implementation", "<device", "<verdict", "scenes", "comparisons",
               "sites compared", "differing", "seconds", "MB"});
  for (const ImplementationRow& row : rows) {
    std::vector<std::string> cells{row.backend, row.implementation, row.device, verdict(row)};
    if (row.outcome == Outcome::absent) {
      cells.resize(10, "-");
    } else {
      const std::array counts{row.scenes, row.comparisons, row.sites_compared, row.sites_differing};
      std::ranges::transform(counts, std::back_inserter(cells), grouped);
      cells.push_back(fmt::format("{:.1f}", row.seconds));
      cells.push_back(fmt::format("{:.0f}", static_cast<double>(row.peak_bytes) / 1e6));
    }
    table.add(std::move(cells));
  }
  fmt::print("{}", table.text());
  for (const ImplementationRow& row : rows) {
    if (!row.reason.empty()) {
      fmt::print("\n  {} on {}: {}\n", row.backend, row.implementation, row.reason);
      if (row.outcome != Outcome::absent && !row.repeat.empty()) {
        fmt::print("    repeat: {}\n", row.repeat);
      }
    }
  }
}

int run_implementations(const Command& command, const Arguments& arguments, const std::string& line) {
  const std::filesystem::path& json = arguments.verify.json;
  require_results_writable(json);
  const auto registry = make_backends();
  for (const std::string& name : arguments.verify.backends) {
    (void)find_backend(registry, name);
  }
  Progress progress;
  const std::vector<ImplementationRow> rows =
      verify_implementations(known_implementations(),
                             {.program = std::filesystem::read_symlink("/proc/self/exe"),
                              .verify = verify_words(command),
                              .backends = arguments.verify.backends,
                              .seconds = arguments.seconds,
                              .resident_bytes = static_cast<std::int64_t>(arguments.gigabytes * 1e9)},
                             progress);
  progress.clear();
  print_matrix(rows);
  const auto count = [&](Outcome outcome) {
    return std::ranges::count(rows, outcome, &ImplementationRow::outcome);
  };
  const auto passed = count(Outcome::passed);
  const auto absent = count(Outcome::absent);
  const auto failed = std::ssize(rows) - passed - absent;
  fmt::print("\n{} pass, {} do not, {} are not there\n", passed, failed, absent);
  nlohmann::json results = nlohmann::json::array();
  std::ranges::transform(rows, std::back_inserter(results), to_json_row<ImplementationRow>);
  write_results(json, "implementations", run_context(line, arguments.verify.quick), std::move(results));
  return failed > 0 || passed == 0 ? disagreement : success;
}

} // namespace

void add_implementations(const Command& program, const std::string& arguments, int& status) {
  const Command command = program.add_subcommand(
      "implementations",
      "Run verify on every implementation of OpenGL and Vulkan that this machine has, each in a process of\n"
      "its own: as installed, Mesa's llvmpipe and softpipe, every Vulkan driver with a file, and zink on "
      "it.\n"
      "A driver that hangs, crashes or takes too much memory is a row of the table.\n"
      "Takes the arguments of verify. Exit status 1 if one does not pass.");
  const auto own = std::make_shared<Arguments>();
  own->verify.add_to(command);
  leave_out_of_help(command, {"--device", "--require"});
  command.add_option("--limit-seconds", own->seconds, "That one implementation of one backend may take")
      .range(1.0, 1e6)
      .capture_default_str();
  command.add_option("--limit-memory", own->gigabytes, "That it may take, in GB")
      .range(0.1, 1e4)
      .capture_default_str();
  command.callback([own, command, arguments, &status] {
    refuse_idle(command, {{.here = true,
                           .options = {"--device", "--require"},
                           .why = "implementations takes every device in turn"}});
    status = run_implementations(command, *own, arguments);
  });
}

} // namespace hdmbench::commands
