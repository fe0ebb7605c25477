// What a run comes to, for a terminal: the page's verdicts, and of its tables the lines that are asked for
// first.

#include "harness/report/accuracy_tables.hpp"
#include "harness/report/html.hpp"
#include "harness/report/report.hpp"
#include "harness/report/table.hpp"
#include "harness/report/timings.hpp"
#include "harness/report/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <ranges>

namespace hdmbench::report {

namespace {

using Align = Table::Align;

std::string lines_of(const Summary& summary) {
  constexpr std::ptrdiff_t most_notes = 5;
  std::string text = fmt::format("  {}\n", summary.sentence);
  for (const std::string& note : summary.notes | std::views::take(most_notes)) {
    text += fmt::format("  {}\n", note);
  }
  if (const auto left = std::ssize(summary.notes) - most_notes; left > 0) {
    text += fmt::format("  {} on the page.\n", plural(left, "more note"));
  }
  return text;
}

std::string agreement(const Results& results) {
  std::string text = "\nAgreement\n" + lines_of(summarise(results));
  if (const auto golden = summarise_golden(results)) {
    text += lines_of(*golden);
  }
  const auto ran = std::ranges::count_if(
      results.implementations, [](const ImplementationRow& row) { return row.outcome != Outcome::absent; });
  if (ran > 0) {
    const auto passed =
        std::ranges::count(results.implementations, Outcome::passed, &ImplementationRow::outcome);
    text += fmt::format("  {} of {} backends on other drivers agree with scalar, too.\n", passed, ran);
  }
  const auto tried = std::ranges::count_if(results.faults,
                                           [](const FaultRow& row) { return row.ran() || !row.as_expected; });
  if (tried > 0) {
    const auto missed = std::ranges::count(results.faults, false, &FaultRow::as_expected);
    text +=
        fmt::format("  {} of {} planted faults and controls came out as expected.\n", tried - missed, tried);
  }
  std::int64_t calls = 0;
  std::int64_t unclean = 0;
  for (const FailingCallsRow& row : results.failing_calls) {
    calls += row.failed;
    unclean += std::ssize(row.unclean);
  }
  if (calls > 0) {
    text += fmt::format("  {} of {} failing calls of drivers ended clean.\n", calls - unclean, calls);
  }
  return text;
}

// The first scene that scalar solved, too, at its largest such size.
std::string speed(const Results& results, const std::string& machine) {
  for (const SceneTimings& timings : scene_timings(results, machine)) {
    for (auto size = timings.sizes.rbegin(); size != timings.sizes.rend(); ++size) {
      Table table({"<backend", "seconds", "over scalar", "million sites/s"});
      bool beside_scalar = false;
      for (const SceneTimings::Line& line : timings.lines) {
        const BenchRow* const row = SceneTimings::find(line, *size);
        if (row == nullptr || !row->seconds_median) {
          continue;
        }
        beside_scalar = beside_scalar || row->speed_up_over_scalar.has_value();
        table.add({timings.label_of(line), seconds_text(*row->seconds_median),
                   !row->counts()              ? "not verified"
                   : row->speed_up_over_scalar ? speed_up_text(*row->speed_up_over_scalar)
                                               : "-",
                   row->msites_per_second ? fmt::format("{:.0f}", *row->msites_per_second) : ""});
      }
      if (beside_scalar) {
        return fmt::format("\nSpeed: {} at {}, a whole solution\n{}", timings.scene,
                           size_text(size->width, size->height), table.text());
      }
    }
  }
  return {};
}

std::string accuracy(const Results& results, const std::string& machine) {
  const auto summary = summarise_accuracy(results, machine);
  if (!summary) {
    return {};
  }
  Table table({"<RMSD to finite elements [px]", "ICM", "fixed point", "interpolation"});
  const auto cell = [](const AccuracyRow* row) {
    return row != nullptr && row->to_fem_nu0.all ? distance_text(*row->to_fem_nu0.all) : std::string("-");
  };
  for (const AccuracyScene& scene : accuracy_scenes(results, machine)) {
    table.add({fmt::format("{}, {}", scene.scene, size_text(scene.width, scene.height)),
               cell(scene.find("icm")), cell(scene.find("fixed-point")), cell(scene.find("interpolation"))});
  }
  return "\nAccuracy\n" + lines_of(*summary) + table.text();
}

// The fastest way to an accuracy beside finite elements.
std::string tradeoff(const std::vector<EqualAccuracyRow>& rows) {
  Table table({"<scene", "RMSD at most [px]", "<fastest", "seconds", "finite elements take"});
  for (const EqualAccuracyRow& row : rows) {
    if (row.ours) {
      table.add({fmt::format("{}, {}", row.scene, size_text(row.width, row.height)),
                 distance_text(row.target), fmt::format("{} on {}", row.ours->method, row.ours->backend),
                 seconds_text(row.ours->seconds_median),
                 row.direct ? speed_up_text(row.direct->ratio) : "-"});
    }
  }
  return rows.empty() ? "" : "\nSpeed at equal accuracy\n" + table.text();
}

} // namespace

} // namespace hdmbench::report

namespace hdmbench {

std::string summary_text(std::span<const std::filesystem::path> files) {
  using namespace report;
  const Results results = load_results(files);
  std::string text;
  for (const std::string& machine : results.machines) {
    text += fmt::format("{}\n", machine);
  }
  text += agreement(results);
  for (const std::string& machine : results.machines) {
    text += speed(results, machine) + accuracy(results, machine) +
            tradeoff(results.of(results.equal_accuracy, machine));
  }
  return text;
}

} // namespace hdmbench
