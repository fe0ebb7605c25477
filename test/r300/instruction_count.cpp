// How many of its 512 instructions the thesis's card needs for our fragment shaders, and for the thesis's own
// evaluation.

#include "harness/cli/commands.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "kernels/data/input_error.hpp"
#include "test/r300/instruction_rows.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <filesystem>

namespace hdmbench::test {
namespace {

/// commands::disagreement where a set of candidates does not fit.
int count(const std::filesystem::path& json) {
  require_results_writable(json);
  if (const std::string reason = why_missing(); !reason.empty()) {
    throw DeviceError(reason);
  }
  ShaderCompiler compiler;
  fmt::print(
      "Compiled for {} ({}), the thesis's Radeon X1300, which need not be there.\n"
      "It has room for {} instructions and {} temporaries. What gl-fragment sends for icm by the number of "
      "candidates and for every\nmethod, and the thesis's evaluation of the whole energy of every vector of "
      "n step sizes (it says: 4 come close, 6 go past):\n",
      compiler.device().name, compiler.device().driver, compiler.limits().instructions,
      compiler.limits().temporaries);
  nlohmann::json results = nlohmann::json::array();
  bool candidates_fit = true;
  for (const InstructionRow& row : measure_instructions(compiler)) {
    results.push_back(to_json(row, compiler));
    candidates_fit = candidates_fit && (row.compilation.resources || row.group != "candidates");
  }
  fmt::print("{}", table_text(results,
                              "group|candidates|energies:vectors|instructions|texture_instructions:of them "
                              "texture|flow_control|temporaries|refusal:does not fit because|shader"));
  write_results(json, "instructions", run_context("--json " + json.string(), false), std::move(results));
  return candidates_fit ? commands::success : commands::disagreement;
}

} // namespace
} // namespace hdmbench::test

int main(int argc, char** argv) {
  using namespace hdmbench;
  CLI::App program(
      "Instructions of the fragment shaders on the thesis's Radeon X1300, as Mesa's r300 driver compiles "
      "them; the card need not be there.\nExit status: 0 all sets of candidates fit, 1 one does not, 2 "
      "there is no such driver here.");
  std::filesystem::path json;
  program.add_option("--json", json, "Write the results to this file, for hdmbench report");
  try {
    program.parse(argc, argv);
    return test::count(json);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? commands::success : commands::bad_input;
  } catch (const std::exception& error) {
    fmt::print(stderr, "instruction_count: {}\n", error.what());
    return commands::bad_input;
  }
}
