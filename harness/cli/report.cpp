#include "harness/report/report.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"

#include <fmt/format.h>

namespace hdmbench::commands {

namespace {

struct Arguments {
  std::vector<std::filesystem::path> results;
  std::filesystem::path output = "hdmbench-report.html";
};

} // namespace

void add_report(CLI::App& program, int& /*status*/) {
  auto* command = program.add_subcommand(
      "report", "Put results into one HTML page that needs no network and no other file.");
  const auto own = std::make_shared<Arguments>();
  command->add_option("results", own->results, "Files that --json wrote, or folders of them")->required();
  command->add_option("--output", own->output, "The page")->capture_default_str();
  command->callback([own] {
    write_report(own->results, own->output);
    fmt::print("{}\n{}\n", summary_text(own->results), own->output.string());
  });
}

} // namespace hdmbench::commands
