#include "harness/report/report.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/scene/file_output.hpp"

#include <fmt/format.h>

namespace hdmbench::commands {

namespace {

struct Arguments {
  std::vector<std::filesystem::path> results;
  std::filesystem::path output = "hdmbench-report.html";
  std::filesystem::path csv;
};

} // namespace

void add_report(const Command& program, int& /*status*/) {
  const Command command = program.add_subcommand(
      "report", "Put results into one HTML page that needs no network and no other file.");
  const auto own = std::make_shared<Arguments>();
  command.add_option("results", own->results, "Files that --json wrote, or folders of them").required();
  command.add_option("--output", own->output, "The page").capture_default_str();
  command.add_option(
      "--csv", own->csv,
      "Write the timings to this file, too: problem, platform, application, fom (seconds), as the "
      "P3 Analysis Library reads them");
  command.callback([own] {
    if (!own->csv.empty()) {
      require_writable(own->csv);
    }
    write_report(own->results, own->output);
    if (!own->csv.empty()) {
      write_p3_csv(own->results, own->csv);
    }
    fmt::print("{}\n{}\n", summary_text(own->results), own->output.string());
  });
}

} // namespace hdmbench::commands
