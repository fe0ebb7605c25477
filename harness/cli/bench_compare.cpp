#include "harness/cli/bench_compare.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/measure/comparison/interleave.hpp"
#include "harness/measure/comparison/rows.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <set>

namespace hdmbench::commands {

namespace {

using comparison::BothSides;
using comparison::Change;
using comparison::ComparedRow;
using comparison::Side;
using comparison::Words;

constexpr int interleaved_samples = 10; ///< a side: two that do not overlap have p = 1e-5
constexpr std::size_t fewest_samples = 5;

/// A command line as separate words: the inverse of shell_word.
Words words_of(const std::string& line) {
  Words words;
  bool inside = false; // a word has begun
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote == 0 && c == ' ') {
      inside = false;
      continue;
    }
    if (!inside) {
      words.emplace_back();
      inside = true;
    }
    if (quote == 0 && c == '\\' && i + 1 < line.size()) {
      words.back() += line[++i];
    } else if (c == '\'') {
      quote = quote == 0 ? c : '\0';
    } else {
      words.back() += c;
    }
  }
  return words;
}

/// A bench command line taken apart.
struct BenchLine {
  Words scenes;
  Words sizes;
  Words options; ///< all else, but what says where results go, how often to measure and what to compare with
};

/// `bench` tells which options take a value.
BenchLine take_apart(const Words& words, const CLI::App& bench) {
  static const std::set<std::string> ours{"--json", "--repeat",     "--compare",
                                          "--with", "--old-binary", "--tolerance"};
  BenchLine line;
  for (std::size_t i = 1; i < words.size(); ++i) { // words[0] is "bench"
    const std::string& word = words[i];
    if (!word.starts_with("--")) {
      line.scenes.push_back(word);
      continue;
    }
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    const CLI::Option* const option = bench.get_option_no_throw(name);
    const bool takes_value = option == nullptr || option->get_items_expected_max() > 0;
    Words value;
    if (equals != std::string::npos) {
      value.push_back(word.substr(equals + 1));
    } else if (takes_value && i + 1 < words.size()) {
      value.push_back(words[++i]);
    }
    if (name == "--size" || name == "--sizes") {
      std::ranges::copy(value, std::back_inserter(line.sizes));
    } else if (!ours.contains(name)) {
      line.options.push_back(name);
      std::ranges::copy(value, std::back_inserter(line.options));
    }
  }
  Words sizes;
  for (const std::string& list : line.sizes) {
    std::ranges::copy(CLI::detail::split(list, ','), std::back_inserter(sizes));
  }
  line.sizes = std::move(sizes);
  return line;
}

/// One run per scene and size, so that the sides take turns often. What the line leaves to bench's defaults
/// is taken from `rows`, else left to the defaults.
std::vector<Words> runs_of(const BenchLine& line, const std::vector<BenchRow>& rows) {
  std::vector<Words> runs;
  std::set<std::string> seen;
  const auto add = [&](const std::string& scene, const std::string& size) {
    if (!seen.insert(scene + ' ' + size).second) {
      return;
    }
    Words words = line.options;
    if (!scene.empty()) {
      words.insert(words.begin(), scene);
    }
    if (!size.empty()) {
      words.insert(words.end(), {"--size", size});
    }
    runs.push_back(std::move(words));
  };
  const Words as_by_default{std::string()};
  if (rows.empty() || (!line.scenes.empty() && !line.sizes.empty())) {
    for (const std::string& scene : line.scenes.empty() ? as_by_default : line.scenes) {
      for (const std::string& size : line.sizes.empty() ? as_by_default : line.sizes) {
        add(scene, size);
      }
    }
    return runs;
  }
  for (const BenchRow& row : rows) {
    const std::string size = fmt::format("{}x{}", row.width, row.height);
    // A scene may go by another name than the file it was loaded from.
    const Words scenes = line.scenes.empty() ? Words{row.scene} : line.scenes;
    std::ranges::for_each(scenes, [&](const std::string& scene) { add(scene, size); });
  }
  return runs;
}

std::filesystem::path this_program() {
  return std::filesystem::read_symlink("/proc/self/exe");
}

std::filesystem::path require_program(const std::filesystem::path& program) {
  if (!std::filesystem::is_regular_file(program) || access(program.c_str(), X_OK) != 0) {
    throw InputError(fmt::format(
        "{}: is no program that can be run; --old-binary wants an hdmbench of before", program.string()));
  }
  return std::filesystem::absolute(program);
}

BothSides measure_both(const CompareArguments& arguments, const CLI::App& bench, const std::string& line,
                       const Side& old, int repeats) {
  const Words words = words_of(old.rows.empty() ? line : old.context.arguments);
  const std::vector<Words> runs = runs_of(take_apart(words, bench), old.rows);
  Progress progress;
  return comparison::interleave(require_program(arguments.old_program), this_program(), runs,
                                repeats > 0 ? repeats : interleaved_samples, progress);
}

BothSides measure_new(const CLI::App& bench, const Side& old, int repeats) {
  std::size_t fewest = 0;
  for (const BenchRow& row : old.rows) {
    const std::size_t count = row.seconds.size();
    fewest = fewest == 0 ? count : std::min(fewest, std::max<std::size_t>(count, 1));
  }
  const int samples =
      repeats > 0 ? repeats : static_cast<int>(comparison::samples_that_can_tell(fewest, fewest_samples));
  BothSides sides{.first = old, .second = {}};
  const std::vector<Words> runs = runs_of(take_apart(words_of(old.context.arguments), bench), old.rows);
  Progress progress;
  progress.set_total(static_cast<double>(runs.size()));
  for (Words words : runs) {
    progress.describe(fmt::format("compare: {} samples of {}", samples, words.front()));
    if (std::ranges::find(words, "--no-ceilings") == words.end()) {
      words.emplace_back("--no-ceilings"); // a comparison does not look at them
    }
    sides.second.append(comparison::run_bench(this_program(), words, samples));
    progress.advance(1.0);
  }
  return sides;
}

BothSides gather(const CompareArguments& arguments, const CLI::App& bench, const std::string& line,
                 int repeats) {
  const Side old = arguments.old_results.empty() ? Side{} : comparison::load_bench(arguments.old_results);
  if (!arguments.old_program.empty()) {
    return measure_both(arguments, bench, line, old, repeats);
  }
  return arguments.new_results.empty() ? measure_new(bench, old, repeats)
                                       : BothSides{old, comparison::load_bench(arguments.new_results)};
}

void print_sides(const BothSides& sides, bool interleaved) {
  const Context& old = sides.first.context;
  const Context& now = sides.second.context;
  fmt::print("old: commit {}, {}, {}, {}\nnew: commit {}, {}, {}, {}\n", old.commit, old.compiler,
             old.machine, old.date, now.commit, now.compiler, now.machine, now.date);
  if (old.machine != now.machine) {
    fmt::print("The machines differ: a ratio is that of the machines as much as that of the programs.\n");
  }
  fmt::print("{}\n", interleaved
                         ? "Measured in turn, a process a sample, so that a drift of the machine hits both."
                         : "Measured at different times: a drift of the machine looks like a difference; "
                           "--old-binary takes turns.");
}

void print_rows(const std::vector<ComparedRow>& rows, double tolerance) {
  Table table({"<scene", "size", "<backend", "<method", "samples", "old s", "new s", "new/old", "interval",
               "p", "<verdict"});
  std::string remarks;
  for (const ComparedRow& row : rows) {
    const std::string threads = row.row.threads ? fmt::format(", {} threads", *row.row.threads) : "";
    if (!row.remark.empty()) {
      remarks += fmt::format("  {} {}x{}, {}, {}: {}\n", row.row.scene, row.row.width, row.row.height,
                             row.row.backend, row.row.method, row.remark);
    }
    if (!row.compared) {
      continue;
    }
    const comparison::Comparison& found = row.comparison;
    const auto verdict = comparison::change_names.at(static_cast<std::size_t>(found.change));
    const bool within = found.change == Change::slower && !found.slower_than_tolerated;
    table.add({row.row.scene, fmt::format("{}x{}", row.row.width, row.row.height), row.row.backend + threads,
               row.row.method, fmt::format("{}+{}", row.first.size(), row.second.size()),
               fmt::format("{:#.4g}", found.first_median), fmt::format("{:#.4g}", found.second_median),
               fmt::format("{:.3f}", found.ratio.estimate),
               fmt::format("{:.3f} ... {:.3f} ({:.0f} %)", found.ratio.low, found.ratio.high,
                           100.0 * found.ratio.coverage),
               fmt::format("{:.2g}", found.p),
               fmt::format("{}{}", verdict,
                           within ? fmt::format(", by less than {:.3g} %", 100.0 * tolerance) : "")});
  }
  fmt::print("\n{}{}", table.text(), remarks);
}

/// What p means for many rows, and the totals.
void print_summary(const std::vector<ComparedRow>& rows) {
  std::array<int, comparison::change_names.size()> counts{};
  int compared = 0;
  int noisy = 0;
  for (const ComparedRow& row : rows) {
    if (row.compared) {
      ++compared;
      ++counts.at(static_cast<std::size_t>(row.comparison.change));
      noisy += row.comparison.noisy() ? 1 : 0;
    }
  }
  std::string totals;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts.at(i) > 0) {
      totals +=
          fmt::format("{}{} {}", totals.empty() ? "" : ", ", counts.at(i), comparison::change_names.at(i));
    }
  }
  fmt::print("\nOf {} compared: {}.{}\n", compared, totals.empty() ? "none" : totals,
             noisy > 0 ? fmt::format(" {} with more noise than the tolerance bears.", noisy) : "");
  fmt::print(
      "new/old: median over all pairs of samples (Hodges-Lehmann), with the interval that the rank test "
      "gives.\np: Mann-Whitney, two-sided; a difference is called one below {}, which chance alone does in "
      "{:.2g} of {} rows.\n",
      comparison::significant_p, comparison::significant_p * compared, compared);
}

} // namespace

void CompareArguments::add_to(CLI::App& command) {
  const auto* const group = "Compare with before (exit status 1: something became slower)";
  auto* const old = command
                        .add_option("--compare", old_results,
                                    "Measure again what this file has, and compare; nothing else is run")
                        ->group(group);
  command.add_option("--with", new_results, "Compare with this file in place of measuring")
      ->needs(old)
      ->group(group);
  command
      .add_option(
          "--old-binary", old_program,
          "An older hdmbench: measure both in turn, what --compare's file has or else what this line says")
      ->excludes("--with")
      ->group(group);
  command.add_option("--tolerance", tolerance, "Percent by which a time may grow")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str()
      ->group(group);
}

int compare_benches(const CompareArguments& arguments, const CLI::App& bench, const std::string& line,
                    int repeats, const std::filesystem::path& json) {
  require_results_writable(json);
  const double tolerance = arguments.tolerance / 100.0;
  const BothSides sides = gather(arguments, bench, line, repeats);
  std::vector<ComparedRow> rows = comparison::compare_rows(sides.first.rows, sides.second.rows, tolerance);
  print_sides(sides, !arguments.old_program.empty());
  print_rows(rows, tolerance);
  print_summary(rows);
  if (!json.empty()) {
    nlohmann::json results = nlohmann::json::array();
    for (ComparedRow& row : rows) {
      row.old_commit = sides.first.context.commit;
      row.new_commit = sides.second.context.commit;
      row.tolerance = tolerance;
      row.interleaved = !arguments.old_program.empty();
      results.push_back(to_json_row(row));
    }
    write_results(json, "compare", run_context(line, false), std::move(results));
  }
  const bool any = std::ranges::any_of(rows, &ComparedRow::compared);
  if (!any) {
    throw InputError("there is nothing to compare: no computation has valid timings on both sides");
  }
  const bool slower =
      std::ranges::any_of(rows, [](const ComparedRow& row) { return row.comparison.slower_than_tolerated; });
  return slower ? disagreement : success;
}

} // namespace hdmbench::commands
