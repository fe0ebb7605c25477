#include "harness/cli/bench.hpp"

#include "harness/measure/comparison.hpp"
#include "harness/measure/median.hpp"
#include "harness/scene/temporary_directory.hpp"

namespace hdmbench::commands {

namespace {

ResultFile read_bench(const std::filesystem::path& file) {
  ResultFile results = read_results(file);
  if (results.command != "bench" || results.results.empty()) {
    throw InputError(
        fmt::format("{}: has no timings; hdmbench bench --json FILE writes them", file.string()));
  }
  return results;
}

/// What the command line of a result file measures now, written to `file`.
ResultFile measure(const std::string& line, int repeats, const std::filesystem::path& file) {
  CLI::App program;
  Call call{.line = line};
  add_bench(program, call);
  program.get_subcommand("bench")->get_option("--json")->take_last();
  program.get_subcommand("bench")->get_option("--repeat")->take_last();
  try {
    program.parse(
        fmt::format("{} --no-ceilings --repeat {} --json {}", line, repeats, shell_word(file.string())));
  } catch (const CLI::ParseError& error) {
    throw InputError(fmt::format("the command line of the old results, \"hdmbench {}\", cannot be run: {}",
                                 line, error.what()));
  }
  return read_bench(file);
}

} // namespace

int compare_benches(const BenchArguments& arguments, const Call& call, int repeats) {
  const ResultFile before = read_bench(arguments.before);
  const TemporaryDirectory folder;
  const ResultFile after = !arguments.after.empty()
                               ? read_bench(arguments.after)
                               : measure(before.context.arguments, repeats,
                                         call.json.empty() ? folder.path() / "bench.json" : call.json);
  const std::vector<ComparedRow> rows =
      compare_rows(before.rows<TimedRow>(), after.rows<TimedRow>(), arguments.tolerance / 100.0);
  if (rows.empty()) {
    throw InputError(fmt::format("{}: has no valid timing to compare with", arguments.before.string()));
  }
  json shown = json::array();
  std::ptrdiff_t passing = 0;
  for (const ComparedRow& row : rows) {
    const TimedRow& old = row.row;
    const bool is_compared = row.new_median > 0.0; // else nobody has measured it
    passing += row.passes() ? 1 : 0;
    shown.push_back(
        {{"scene", old.scene},
         {"width", old.width},
         {"height", old.height},
         {"backend", old.backend},
         {"method", old.method},
         {"threads", old.threads},
         {"old_s", median(old.seconds)},
         {"new_s", is_compared ? json(row.new_median) : json()},
         {"ratio", is_compared ? json(row.new_median / row.old_median) : json()},
         {"p", is_compared ? json(row.p) : json()},
         {"verdict", row.remark.empty() ? std::string(change_names.at(static_cast<std::size_t>(row.change)))
                                        : row.remark}});
  }
  for (const ResultFile* const file : {&before, &after}) {
    const Context& context = file->context;
    fmt::print("{}: commit {}, {}, {}, {}\n", file == &before ? "old" : "new", context.commit,
               context.compiler, context.machine, context.date);
  }
  fmt::print("\n{}\n{} of {} timings are not slower by more than {:.3g} % (medians; Mann-Whitney, one-sided, "
             "p < {:g})\n",
             table_text(shown, "scene|size|backend|method|threads|old_s|new_s|ratio:new/old|p|verdict"),
             passing, rows.size(), arguments.tolerance, significant_p);
  return passing == std::ssize(rows) ? success : disagreement;
}

} // namespace hdmbench::commands
