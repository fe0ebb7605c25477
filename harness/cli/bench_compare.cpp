#include "harness/cli/bench_compare.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/measure/comparison.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/temporary_directory.hpp"
#include "kernels/data/input_error.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>

namespace hdmbench::commands {

namespace {

constexpr int enough_samples = 10; ///< even beside the three that bench takes by default

ResultFile read_bench(const std::filesystem::path& file) {
  ResultFile results = read_results(file);
  if (results.command != "bench" || results.results.empty()) {
    throw InputError(
        fmt::format("{}: has no timings; hdmbench bench --json FILE writes them", file.string()));
  }
  return results;
}

/// What the command line of a result file measures now, written to `json`.
ResultFile measure(const std::string& line, int repeats, const std::filesystem::path& json) {
  CLI::App program;
  int status = success;
  add_bench(Command(program), line, status, nullptr);
  const Command bench(*program.get_subcommand("bench"));
  bench.option("--json").take_last();
  bench.option("--repeat").take_last();
  try {
    program.parse(
        fmt::format("{} --no-ceilings --repeat {} --json {}", line, repeats, shell_word(json.string())));
  } catch (const CLI::ParseError& error) {
    throw InputError(fmt::format("the command line of the old results, \"hdmbench {}\", cannot be run: {}",
                                 line, error.what()));
  }
  return read_bench(json);
}

ResultFile new_results(const CompareArguments& arguments, const ResultFile& before, int repeats,
                       const std::filesystem::path& json) {
  if (!arguments.after.empty()) {
    return read_bench(arguments.after);
  }
  const TemporaryDirectory folder;
  return measure(before.context.arguments, repeats > 0 ? repeats : enough_samples,
                 json.empty() ? folder.path() / "bench.json" : json);
}

} // namespace

void CompareArguments::add_to(const Command& command) {
  const auto* const group =
      "Compare with before (exit status 1: slower, inconclusive, missing, other device)";
  const Option old = command
                         .add_option("--compare", before,
                                     "Measure again what this result file has, and compare; nothing else is "
                                     "run")
                         .group(group);
  command.add_option("--with", after, "Compare with this result file in place of measuring")
      .needs(old)
      .excludes("--json")
      .group(group);
  command.add_option("--tolerance", tolerance, "Percent by which a time may grow")
      .range(0.1, 1000.0)
      .capture_default_str()
      .group(group);
}

int compare_benches(const CompareArguments& arguments, int repeats, const std::filesystem::path& json) {
  const ResultFile before = read_bench(arguments.before);
  const ResultFile after = new_results(arguments, before, repeats, json);
  const auto rows =
      compare_rows(before.rows<TimedRow>(), after.rows<TimedRow>(), arguments.tolerance / 100.0);
  for (const auto& [side, file] : {std::pair{"old", &before}, std::pair{"new", &after}}) {
    const Context& context = file->context;
    fmt::print("{}{}: commit {}, {}, {}, {}\n", side == std::string_view("old") ? "\n" : "", side,
               context.commit, context.compiler, context.machine, context.date);
  }
  Table table(
      {"<scene", "size", "<backend", "<method", "samples", "old s", "new s", "new/old", "p", "<verdict"});
  std::string remarks;
  for (const ComparedRow& row : rows) {
    const TimedRow& old = row.row;
    if (!row.remark.empty()) {
      remarks += fmt::format("  {} {}x{}, {}, {}: {}\n", old.scene, old.width, old.height, old.backend,
                             old.method, row.remark);
    }
    if (row.found) {
      table.add({old.scene, fmt::format("{}x{}", old.width, old.height),
                 old.backend + (old.threads ? fmt::format(", {} threads", *old.threads) : ""), old.method,
                 fmt::format("{}+{}", old.seconds.size(), row.new_samples),
                 fmt::format("{:#.4g}", row.found->old_median), fmt::format("{:#.4g}", row.found->new_median),
                 fmt::format("{:.3f}", row.found->new_median / row.found->old_median),
                 fmt::format("{:.2g}", row.found->p),
                 std::string(change_names.at(static_cast<std::size_t>(row.found->change)))});
    }
  }
  const auto passing = std::ranges::count_if(rows, &ComparedRow::passes);
  fmt::print(
      "\n{}{}\n{} of {} timings are not slower by more than {:.3g} % (medians; Mann-Whitney, one-sided, "
      "p < {:g})\n",
      table.text(), remarks, passing, rows.size(), arguments.tolerance, significant_p);
  if (rows.empty()) {
    throw InputError(fmt::format("{}: has no valid timing to compare with", arguments.before.string()));
  }
  return passing == std::ssize(rows) ? success : disagreement;
}

} // namespace hdmbench::commands
