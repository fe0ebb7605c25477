#include "harness/judge/atlas/atlas.hpp"
#include "harness/cli/arguments.hpp"

#include <cstdio>
#include <set>

namespace hdmbench::commands {

namespace {

struct Arguments {
  std::vector<std::string> entries;
  std::string backend = "scalar";
  bool quick = false;
  bool list = false;
};

std::string threshold_text(const atlas::SeriesResult& series) {
  if (!series.first_failed) {
    return "no failure";
  }
  return series.last_good
             ? fmt::format("fails at {:.6g}, not yet at {:.6g}", *series.first_failed, *series.last_good)
             : fmt::format("fails everywhere, {:.6g} on", *series.first_failed);
}

/// A row a value of the knob, a column a method.
void print(const atlas::EntryResult& result) {
  const atlas::Entry& entry = *result.entry;
  json rows = json::array();
  std::string columns = fmt::format("knob:{}", entry.knob);
  std::string below;
  for (std::size_t of = 0; of < result.series.size(); ++of) {
    const atlas::SeriesResult& series = result.series[of];
    const std::string key = fmt::format("series{}", of);
    columns += fmt::format("|{}:{}", key, series.name);
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      const atlas::Point& point = series.points[i];
      json& row = i < rows.size() ? rows[i] : rows.emplace_back();
      row["knob"] = fmt::format("{:.6g}", point.knob);
      row[key] =
          (point.error ? fmt::format("{:.3g}", *point.error) : "not finite") + (point.failed ? " !" : "");
      std::set<std::string> warned = row.value("warned", std::set<std::string>{});
      warned.insert(point.warnings.begin(), point.warnings.end());
      row["warned"] = warned;
    }
    below += series.points.empty()
                 ? ""
                 : fmt::format("  threshold  {}: {}\n", series.name, threshold_text(series));
    below += series.absence.empty() ? "" : fmt::format("  refuses    {}: {}\n", series.name, series.absence);
  }
  fmt::print("\n{}: {}\n  why        {}\n  measured   {}; ! is more than {:.6g}\n{}{}  survives   {}\n",
             entry.name, entry.title, entry.mechanism, entry.measure, entry.limit,
             table_text(rows, columns + "|warned:warned of"), below, entry.survivor);
  std::fflush(stdout); // into a pipe too: the next entry may take seconds
}

int run_atlas(Arguments& arguments, Call& call) {
  if (arguments.list) {
    json rows = json::array();
    for (const atlas::Entry& entry : atlas::entries()) {
      rows.push_back({{"entry", entry.name}, {"title", entry.title}, {"knob", entry.knob}});
    }
    fmt::print("{}", table_text(rows, "entry|title:what fails|knob"));
    return success;
  }
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
  json rows = json::array();
  for (const atlas::Entry* const entry : chosen) {
    const atlas::EntryResult result = atlas::run_entry(*entry, backend, arguments.quick, progress);
    progress.clear();
    print(result);
    if (!call.json.empty()) {
      rows.push_back(atlas::atlas_row(result, std::filesystem::absolute(call.json).parent_path()));
    }
  }
  call.write(std::move(rows), arguments.quick);
  return success;
}

} // namespace

void add_atlas(CLI::App& program, Call& call) {
  const auto [command, own] =
      declare(program, call, "atlas",
              "Where the methods fail: families of scenes along one knob each, from healthy to harmful, the "
              "error of every\nmethod, from where on it fails, how that shows, and what survives.",
              run_atlas);
  CLI::Option* const list = add_flag(command, "--list", own.list, "Name the entries and stop");
  add_option(command, "entries", own.entries, "Entries by name (none: all; see --list)")->excludes(list);
  add_option(command, "--backend", own.backend, "Where it is computed; the bits are the same everywhere")
      ->excludes(list);
  add_flag(command, "--quick", own.quick, "Fewer values of every knob; the results say so")->excludes(list);
  add_json(command, call, "Write the results to this file, pictures beside it")->excludes(list);
}

} // namespace hdmbench::commands
