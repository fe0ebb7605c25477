// How many of its 512 instructions the thesis's card needs for our fragment shader, and for the thesis's own
// evaluation.

#include "harness/cli/commands.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "kernels/data/input_error.hpp"
#include "test/r300/instruction_rows.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace hdmbench::test {
namespace {

/// Instructions, and where some are of branches or loops how many: a loop is counted once, whatever it costs.
std::string instructions_text(const Resources& resources) {
  return resources.flow_control == 0
             ? fmt::format("{}", resources.instructions)
             : fmt::format("{} ({} of flow control)", resources.instructions, resources.flow_control);
}

void print(const std::string& title, const std::vector<InstructionRow>& rows) {
  nlohmann::json table = nlohmann::json::array();
  for (const InstructionRow& row : rows) {
    const auto& [resources, refusal] = row.compilation;
    table.push_back({{"candidates", row.candidates},
                     {"fits", resources ? "yes" : "NO: " + refusal},
                     {"shader", row.shader}});
    if (row.energies > 0) {
      table.back()["vectors"] = row.energies;
    }
    if (row.scalar_operations) {
      table.back()["scalar_operations"] = *row.scalar_operations;
    }
    if (resources) {
      table.back().update({{"instructions", instructions_text(*resources)},
                           {"texture", resources->texture_instructions},
                           {"temporaries", resources->temporaries}});
    }
  }
  fmt::print("\n{}\n{}", title,
             table_text(table, "candidates|vectors|instructions|texture:of them texture|temporaries|"
                               "scalar_operations|fits|shader"));
}

/// commands::disagreement where a set of candidates does not fit.
int count(const std::filesystem::path& json) {
  require_results_writable(json);
  if (const std::string reason = why_missing(); !reason.empty()) {
    throw DeviceError(reason);
  }
  ShaderCompiler compiler;
  const Resources& limits = compiler.limits();
  auto candidates = measure_candidates(compiler);
  auto methods = measure_methods(compiler);
  auto vectors = measure_vectors(compiler);
  Progress progress;
  progress.describe("a second opinion by glslang and spirv-opt");
  progress.set_total(static_cast<double>(candidates.size() + methods.size() + vectors.size()));
  for (auto* const rows : {&candidates, &methods, &vectors}) {
    add_second_opinions(*rows, progress);
  }
  progress.clear();

  fmt::print("Compiled for {} ({}), the thesis's Radeon X1300, which need not be there.\n"
             "It has room for {} instructions and {} temporaries.\n",
             compiler.device().name, compiler.device().driver, limits.instructions, limits.temporaries);
  print("What gl-fragment sends for icm, by the number of candidates:", candidates);
  const auto refused = std::ranges::find_if_not(
      candidates, [](const InstructionRow& row) { return row.compilation.resources.has_value(); });
  fmt::print("  {}\n", refused == candidates.end()
                           ? fmt::format("All fit; {} candidates are the most that a set can have.",
                                         candidates.back().candidates)
                           : fmt::format("{} candidates do not fit.", refused->candidates));
  print("What it sends for every method:", methods);
  print("The thesis's evaluation, the whole energy of every vector of n step sizes (it says: 4 come close, 6 "
        "go "
        "past):",
        vectors);
  if (!json.empty()) {
    nlohmann::json results = nlohmann::json::array();
    for (const auto* const rows : {&candidates, &methods, &vectors}) {
      for (const InstructionRow& row : *rows) {
        results.push_back(to_json(row, compiler));
      }
    }
    write_results(json, "instructions", run_context("--json " + json.string(), false), std::move(results));
  }
  return refused == candidates.end() ? commands::success : commands::disagreement;
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
