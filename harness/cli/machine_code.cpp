#include "harness/check/machine_code/machine_code.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/report/ci_files.hpp"

#include <fmt/ranges.h>

#include <map>
#include <set>
#include <tuple>

namespace hdmbench::commands {

namespace {

const Option<std::vector<std::string>>
    targets("--targets", "GPUs with commas (none: all; one that is named must be compiled for)");
const Option<std::vector<std::string>>
    kernels("--kernels",
            "Only kernels with one of these words in their names: \"elastic.cl\", \"relax\", \"3 axes\"");
const Option<bool>
    planted("--planted",
            "Take the word out of every text that forbids to fuse, and see whether that is found");
const Option<OutputFile> junit("--junit", "Write the rows to this file as JUnit XML, too, for CI");

bool is_there(const json& row) {
  return row["verdict"] != "not there";
}

/// One row for each target: sums over its kernels, and the largest of what limits it.
json sums_of_targets(const json& rows) {
  std::vector<json> sums;
  for (const json& row : rows) {
    if (sums.empty() || sums.back()["target"] != row["target"]) {
      sums.push_back({{"target", row["target"]},
                      {"gpu", row["gpu"]},
                      {"compiler", row["compiler"]},
                      {"kernels", 0},
                      {"not_compiled", 0}});
    }
    json& sum = sums.back();
    if (row["fused"].is_null()) {
      sum["not_compiled"] = sum["not_compiled"].get<int>() + 1;
      sum["compiler"] = is_there(row) ? row["compiler"] : json("not there");
      continue;
    }
    sum["kernels"] = sum["kernels"].get<int>() + 1;
    for (const char* const key : {"multiplies", "adds", "fused"}) {
      sum[key] = sum.value(key, 0) + row[key].get<int>();
    }
    for (const char* const key : {"registers", "spills", "local_bytes"}) {
      if (!row[key].is_null()) {
        sum[key] = std::max(sum.value(key, 0), row[key].get<int>());
      }
    }
  }
  return sums;
}

/// Returns what is said of a row that is no pass, with some of its lines.
std::string lines_of(const json& row) {
  std::string text = is_there(row)
                         ? row_text("\n{target}: {text}, {kernel}, {axes} axes: {verdict} {reason}\n", row)
                         : row_text("\n{target}: not there: {reason}\n", row);
  for (const json& line : row["fused_lines"]) {
    text += fmt::format("  {}\n", line.get<std::string>());
  }
  return text;
}

/// Names the texts that a target's compiler fused nothing of, though nothing forbade it.
std::set<std::string> not_found(const json& rows) {
  std::map<std::string, int> fused; // by target and text
  for (const json& row : rows) {
    const auto target = std::ranges::find(gpu_targets(), row["target"].get<std::string>(), &GpuTarget::name);
    if (is_there(row) && target->fuses) {
      fused[row_text("{target}: {text}, {axes} axes", row)] +=
          row["fused"].is_null() ? 0 : row["fused"].get<int>();
    }
  }
  std::set<std::string> names;
  for (const auto& [name, count] : fused) {
    if (count == 0) {
      names.insert(name);
    }
  }
  return names;
}

int judge(const Call& call, const json& rows) {
  if (call[planted]) {
    const std::set<std::string> missed = not_found(rows);
    fmt::print("\nWithout the word that forbids it: {}\n",
               missed.empty() ? "fused operations are found in every text, on every target that has them"
                              : fmt::format("NOTHING IS FOUND in {}", fmt::join(missed, "; ")));
    return missed.empty() ? success : disagreement;
  }
  constexpr int most = 10;
  int bad = 0;
  for (const json& row : rows) {
    const bool is_bad = row["verdict"] != "no fused operation";
    if (is_bad && (bad < most || !is_there(row))) {
      fmt::print("{}", lines_of(row));
    }
    bad += is_bad && is_there(row) ? 1 : 0;
  }
  const auto there = std::ranges::count_if(rows, is_there);
  fmt::print(
      "\n{}\n",
      bad == 0
          ? fmt::format(
                "No fused operation in {} programs: on these GPUs the bits are the specification's, as far "
                "as arithmetic goes",
                there)
          : fmt::format("{} of {} programs do not pass", bad, there));
  return bad == 0 ? success : disagreement;
}

int run_machine_code(Call& call) {
  Progress progress;
  json rows = machine_code({.targets = call[targets],
                            .kernels = call[kernels],
                            .word = call[planted] ? Word::taken_out : Word::kept},
                           progress);
  progress.clear();
  for (const json& row : rows) {
    if (!is_there(row) && !call[targets].empty()) {
      throw DeviceError(row_text("{target}: {reason}", row));
    }
  }
  if (std::ranges::none_of(rows, is_there)) {
    throw DeviceError(row_text("no compiler for GPUs is there; the first of them: {reason}", rows.front()));
  }
  fmt::print(
      "{}",
      table_text(sums_of_targets(rows),
                 "target|gpu|compiler|kernels|not_compiled:not compiled|multiplies|adds|fused|registers:most "
                 "registers|spills|local_bytes:most local bytes"));
  const int status = judge(call, rows);
  report::write_junit_of_machine_code(call[junit], rows);
  call.write(std::move(rows));
  return status;
}

} // namespace

void add_machine_code(CLI::App& program, Call& call) {
  add_command(
      program, call, "machine-code", run_machine_code,
      "Compile every kernel for GPUs that are not there.\n"
      "Compile every kernel for GPUs that need not be there (AMD by Mesa's RADV and by clang, NVIDIA by\n"
      "clang, Intel by ocloc), and read what became of its arithmetic: where nothing is fused, the bits are\n"
      "the specification's, as far as arithmetic goes. Registers, spills and local memory say how it would\n"
      "run. A compiler that is not there is named. Exit status 1 where something is fused or refused.",
      {targets, kernels, planted, junit, Options(option::json, "Write the rows to this file")},
      {"--planted excludes --json --junit"}, false);
}

} // namespace hdmbench::commands
