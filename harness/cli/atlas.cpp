#include "harness/judge/atlas/atlas.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace hdmbench::commands {

namespace {

struct Arguments {
  std::vector<std::string> entries;
  std::string backend = "scalar";
  std::filesystem::path json;
  bool quick = false;
  bool list = false;
};

void print_list() {
  Table table({"<entry", "<what fails", "<knob"});
  for (const atlas::Entry& entry : atlas::entries()) {
    table.add({std::string(entry.name), std::string(entry.title), std::string(entry.knob)});
  }
  fmt::print("{}", table.text());
}

std::string figure(const atlas::Point& point) {
  return fmt::format("{}{}", point.error ? fmt::format("{:.3g}", *point.error) : "not finite",
                     point.failed ? " !" : "  ");
}

/// The entry's kinds that were warned of at one value of the knob; behind those that not every method brings,
/// how many do.
std::string warned(const atlas::Entry& entry, const std::vector<const atlas::Point*>& points) {
  std::string text;
  for (const std::string_view kind : entry.warnings) {
    const auto count = static_cast<std::size_t>(std::ranges::count_if(points, [&](const auto* point) {
      return std::ranges::find(point->warnings, kind) != point->warnings.end();
    }));
    if (count > 0) {
      text += fmt::format("{}{}", text.empty() ? "" : ", ", kind);
      text += count < points.size() ? fmt::format(" ({} of {})", count, points.size()) : "";
    }
  }
  return text;
}

std::string threshold_text(const atlas::Threshold& threshold) {
  if (!threshold.failed) {
    return "no failure";
  }
  return threshold.good
             ? fmt::format("fails at {:.6g}, not yet at {:.6g}", *threshold.failed, *threshold.good)
             : fmt::format("fails everywhere, {:.6g} on", *threshold.failed);
}

void print(const atlas::EntryResult& result) {
  const atlas::Entry& entry = *result.entry;
  fmt::print("\n{}: {}\n", entry.name, entry.title);
  const auto line = [](const char* label, std::string_view text) {
    if (!text.empty()) {
      fmt::print("  {:<10} {}\n", label, text);
    }
  };
  line("why", entry.mechanism);
  line("measured", fmt::format("{}; ! is more than {:.6g}", entry.measure, entry.limit));
  std::vector<const atlas::SeriesResult*> present;
  std::vector<Table::Column> columns{{std::string(entry.knob)}};
  for (const atlas::SeriesResult& series : result.series) {
    if (!series.points.empty()) {
      present.push_back(&series);
      columns.push_back({series.name + "  "});
    }
    if (!series.absence.empty()) {
      line(series.points.empty() ? "not there" : "refuses",
           fmt::format("{}: {}", series.name, series.absence));
    }
  }
  columns.push_back("<warned of");
  Table table(columns);
  const auto length = [](const atlas::SeriesResult* series) { return series->points.size(); };
  const auto longest = std::ranges::max_element(present, {}, length);
  for (std::size_t i = 0; longest != present.end() && i < (*longest)->points.size(); ++i) {
    std::vector<std::string> cells{fmt::format("{:.6g}", (*longest)->points[i].knob)};
    std::vector<const atlas::Point*> points;
    for (const atlas::SeriesResult* const series : present) {
      if (i < series->points.size()) {
        points.push_back(&series->points[i]);
      }
      cells.push_back(i < series->points.size() ? figure(series->points[i]) : "refused");
    }
    cells.push_back(warned(entry, points));
    table.add(std::move(cells));
  }
  fmt::print("{}", table.text());
  for (const atlas::SeriesResult* const series : present) {
    line(series == present.front() ? "threshold" : "",
         fmt::format("{}: {}", series->name, threshold_text(series->threshold())));
  }
  line("survives", entry.survivor);
  std::fflush(stdout); // into a pipe too: the next entry may take seconds
}

void run_atlas(const Arguments& arguments, const Command& command, const std::string& command_line) {
  refuse_idle(command, {{.here = arguments.list,
                         .options = {"entries", "--backend", "--quick", "--json"},
                         .why = "--list names the entries and stops"}});
  if (arguments.list) {
    print_list();
    return;
  }
  require_results_writable(arguments.json);
  std::vector<const atlas::Entry*> chosen;
  for (const std::string& name : arguments.entries) {
    chosen.push_back(&atlas::find_entry(name));
  }
  if (chosen.empty()) {
    std::ranges::transform(atlas::entries(), std::back_inserter(chosen),
                           [](const atlas::Entry& entry) { return &entry; });
  }
  const auto registry = make_backends();
  const Backend& backend = find_backend(registry, arguments.backend);
  Progress progress;
  double total = 0.0;
  for (const atlas::Entry* const entry : chosen) {
    total += static_cast<double>((arguments.quick ? entry->quick_knobs : entry->knobs).size());
  }
  progress.set_total(total);
  const std::filesystem::path folder =
      arguments.json.empty() ? "" : std::filesystem::absolute(arguments.json).parent_path();
  nlohmann::json rows = nlohmann::json::array();
  for (const atlas::Entry* const entry : chosen) {
    const atlas::EntryResult result = atlas::run_entry(*entry, backend, arguments.quick, progress);
    progress.clear();
    print(result);
    if (!arguments.json.empty()) {
      rows.push_back(atlas::atlas_row(result, folder));
    }
  }
  write_results(arguments.json, "atlas", run_context(command_line, arguments.quick), std::move(rows));
}

} // namespace

void add_atlas(const Command& program, const std::string& arguments) {
  const Command command = program.add_subcommand(
      "atlas", "Where the methods fail: families of scenes along one knob each, from healthy to harmful, the "
               "error of every\nmethod, from where on it fails, how that shows, and what survives.");
  const auto own = std::make_shared<Arguments>();
  command.add_option("entries", own->entries, "Entries by name (none: all; see --list)");
  command.add_flag("--list", own->list, "Name the entries and stop");
  command.add_option("--backend", own->backend, "Where it is computed; the bits are the same everywhere")
      .capture_default_str();
  command.add_flag("--quick", own->quick, "Fewer values of every knob; the results say so");
  command.add_option("--json", own->json, "Write the results to this file, pictures beside it");
  command.callback([own, command, arguments] { run_atlas(*own, command, arguments); });
}

} // namespace hdmbench::commands
