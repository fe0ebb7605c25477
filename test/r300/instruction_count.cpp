// How many of its 512 instructions the thesis's card needs for our fragment shader, and for the thesis's own
// evaluation.

#include "harness/commands/arguments.hpp"
#include "harness/context.hpp"
#include "harness/file_output.hpp"
#include "harness/table.hpp"
#include "kernels/input_error.hpp"
#include "test/r300/instruction_rows.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace hdmbench::test {
namespace {

std::string number_text(std::optional<int> number) {
  return number ? fmt::format("{}", *number) : "-";
}

Table::Column words(std::string title) {
  return {std::move(title), Table::Align::left};
}

void print(const std::string& title, const std::vector<InstructionRow>& rows, const Resources& limits) {
  fmt::print("\n{}\n", title);
  const bool evaluates = rows.front().energies > 0;
  std::vector<Table::Column> columns{{"candidates"}};
  if (evaluates) {
    columns.push_back({"energies"});
  }
  columns.insert(columns.end(), {{"instructions"},
                                 {"limit"},
                                 {"of them texture"},
                                 {"temporaries"},
                                 {"limit"},
                                 {"scalar operations"},
                                 words("fits"),
                                 words("shader")});
  Table table(columns);
  for (const InstructionRow& row : rows) {
    const auto& [resources, refusal] = row.compilation;
    const auto of = [&](int Resources::*which) {
      return number_text(resources ? std::optional((*resources).*which) : std::nullopt);
    };
    std::vector<std::string> cells{row.candidates > 0 ? fmt::format("{}", row.candidates) : "-"};
    if (evaluates) {
      cells.push_back(fmt::format("{}", row.energies));
    }
    for (std::string cell : {of(&Resources::instructions), fmt::format("{}", limits.instructions),
                             of(&Resources::texture_instructions), of(&Resources::temporaries),
                             fmt::format("{}", limits.temporaries), number_text(row.scalar_operations),
                             resources ? std::string("yes") : "NO: " + refusal, row.shader}) {
      cells.push_back(std::move(cell));
    }
    table.add(std::move(cells));
  }
  fmt::print("{}", table.text());
}

int count(const std::filesystem::path& json) {
  if (!json.empty()) {
    require_writable(json);
  }
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

  fmt::print("Compiled for {} ({}), the thesis's Radeon X1300, which need not be there.\n",
             compiler.device().name, compiler.device().driver);
  print("What gl-fragment sends for icm, by the number of candidates:", candidates, limits);
  const auto refused = std::ranges::find_if_not(
      candidates, [](const InstructionRow& row) { return row.compilation.resources.has_value(); });
  fmt::print("  {}\n", refused == candidates.end()
                           ? fmt::format("All fit; {} candidates are the most that a set can have.",
                                         candidates.back().candidates)
                           : fmt::format("{} candidates do not fit.", refused->candidates));
  print("What it sends for every method:", methods, limits);
  print("The thesis's evaluation, the whole energy of candidate vectors from n step sizes (it says that 4 "
        "come close "
        "to 512 and 6 go past):",
        vectors, limits);
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
