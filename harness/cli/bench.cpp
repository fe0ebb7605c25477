#include "harness/measure/bench.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/cli/bench_compare.hpp"
#include "harness/cli/bench_on_ranks.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/gates.hpp"
#include "harness/measure/choices.hpp"
#include "harness/measure/median.hpp"
#include "harness/measure/memory_use.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/ci_files.hpp"
#include "harness/report/table.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/published.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <set>

namespace hdmbench::commands {

namespace {

struct Arguments : CommonArguments {
  int repeats = 3;
  std::vector<std::string> work{"dense", "active"};
  bool scaling = false;
  bool no_ceilings = false;
  std::filesystem::path benchmark_json; ///< empty: nobody asked for it
  std::optional<std::string> reference; ///< "none" or a backend; none given: scalar, of images not too large
};

/// Scalar takes minutes for one solution of an image larger than this.
constexpr std::size_t most_sites_for_scalar = std::size_t{4096} * 4096;

/// The scenes of Tables 5.2, 5.4, 5.6 and 5.8.
std::vector<std::string> published_scenes() {
  std::vector<std::string> scenes;
  for (const PublishedTiming& row : published_timings()) {
    if (std::ranges::find(scenes, row.scene) == scenes.end()) {
      scenes.emplace_back(row.scene);
    }
  }
  return scenes;
}

/// Three digits that matter: 0.00123, 1.23, 123.
std::string seconds_text(double seconds) {
  const int decimals = seconds >= 100.0  ? 0
                       : seconds >= 10.0 ? 1
                       : seconds >= 1.0  ? 2
                       : seconds >= 0.1  ? 3
                                         : 4;
  return fmt::format("{:.{}f}", seconds, decimals);
}

/// "openmp, active", "openmp, 1 thread".
std::string row_name(const BenchResult& result, const std::vector<BenchResult>& all) {
  const bool differ = std::ranges::any_of(all, [&](const BenchResult& other) {
    return other.backend == result.backend && other.threads != result.threads;
  });
  return fmt::format("{}{}{}", result.backend, result.work == Work::active ? ", active" : "",
                     differ ? fmt::format(", {} thread{}", result.threads, result.threads == 1 ? "" : "s")
                            : "");
}

/// How near dense runs come to what was measured of their devices.
void print_ceilings(const std::vector<BenchResult>& results) {
  Table table({"<dense, of what is measured", "GB/s", "copy GB/s", "Gop/s", "most Gop/s", "% of ceiling",
               "<binds", "bytes/update", "ops/update"});
  std::string remarks;
  for (const BenchResult& result : results) {
    if (result.samples.empty() || result.work != Work::dense) {
      continue;
    }
    if (!result.cost || !result.share) {
      remarks += fmt::format("  {}: no percentage of a ceiling: {}\n", row_name(result, results),
                             result.no_ceilings);
      continue;
    }
    if (result.share->percent > 100.0) {
      remarks +=
          fmt::format("  {}: more than its ceiling, so this machine was busy while that was measured\n",
                      row_name(result, results));
    }
    const double seconds = median_seconds(result.samples, &Timings::compute);
    table.add({row_name(result, results), fmt::format("{:.2f}", result.cost->bytes / seconds * 1e-9),
               fmt::format("{:.2f}", median(result.ceilings->copy_bytes_per_second) * 1e-9),
               fmt::format("{:.2f}", result.cost->operations / seconds * 1e-9),
               fmt::format("{:.1f}", median(result.ceilings->operations_per_second) * 1e-9),
               fmt::format("{:.1f}", result.share->percent),
               result.share->binding == Binding::memory ? "memory" : "arithmetic",
               fmt::format("{:.1f}", result.cost->bytes / result.site_updates),
               fmt::format("{:.1f}", result.cost->operations / result.site_updates)});
  }
  fmt::print("{}{}", table.text(), remarks);
}

std::string number_or_dash(const std::optional<double>& value, int decimals) {
  return value ? fmt::format("{:.{}f}", *value, decimals) : "-";
}

void print_scene(const Scene& scene, const std::vector<BenchResult>& results, bool with_ceilings) {
  const auto ran = std::ranges::find_if(results, [](const auto& one) { return !one.samples.empty(); });
  const BenchResult& some = ran == results.end() ? results.front() : *ran;
  fmt::print("\n{}, {} x {}: {}, {} iterations, {:.4g} million site updates\n", scene.name,
             scene.extent().width, scene.extent().height, method_name(scene), some.iterations,
             some.site_updates * 1e-6);
  const bool as_published = scene.energy == EnergyModel::hdm && scene.extent().width == scene.extent().height;
  const PublishedTiming* published =
      as_published ? published_timing(scene.name, scene.extent().width) : nullptr;
  if (published != nullptr) {
    fmt::print("  thesis, table {}: GPU {} s, CPU {} s, speed-up {}\n", published->table,
               published->gpu_seconds, published->cpu_seconds, published->speed_up);
  }
  Table table({"<backend", "seconds", "min", "max", "projection", "upload", "compute", "readback", "set-up",
               "Msites/s", "bytes/site", "speed-up", "over dense"});
  // The program and its drivers weigh more than a small image.
  const bool large = scene.extent().sites() >= 1'000'000;
  std::string remarks;
  for (const BenchResult& result : results) {
    if (!result.valid) {
      remarks += fmt::format("  {}: no speed-up: {}\n", row_name(result, results), result.reason);
    }
    if (result.samples.empty()) {
      continue;
    }
    const auto [fastest, slowest] = std::ranges::minmax_element(result.samples, {}, &Timings::total);
    const auto part = [&](auto which) { return seconds_text(median_seconds(result.samples, which)); };
    table.add({row_name(result, results), part(&Timings::total), seconds_text(fastest->total()),
               seconds_text(slowest->total()), part(&Timings::projection), part(&Timings::upload),
               part(&Timings::compute), part(&Timings::readback), seconds_text(result.setup_seconds),
               fmt::format("{:.1f}", msites_per_second(result)),
               large ? number_or_dash(result.bytes_per_site, 0) : "-", number_or_dash(result.speed_up, 2),
               number_or_dash(result.speed_up_over_dense, 2)});
  }
  fmt::print("{}{}", table.text(), remarks);
  if (with_ceilings) {
    print_ceilings(results);
  }
}

/// One line per method of --methods on one scene.
class MethodTable {
public:
  explicit MethodTable(std::span<const Backend* const> backends) : table_(columns(backends)) {}

  /// Of the dense runs with all threads.
  void add(const Scene& scene, const std::vector<BenchResult>& results) {
    const double work = results.front().site_updates / static_cast<double>(scene.extent().sites());
    std::vector<std::string> cells{method_name(scene), std::to_string(scene.schedule.iterations),
                                   results.front().samples.empty() ? "-" : fmt::format("{:.2f}", work)};
    for (const BenchResult& result : results) {
      const bool has_more_threads = std::ranges::any_of(results, [&](const BenchResult& other) {
        return other.backend == result.backend && other.threads > result.threads;
      });
      if (result.work != Work::dense || has_more_threads) {
        continue;
      }
      cells.push_back(result.valid             ? seconds_text(median_seconds(result.samples, &Timings::total))
                      : result.samples.empty() ? "-"
                                               : "differs");
    }
    table_.add(std::move(cells));
  }

  void print(const Scene& scene) const {
    fmt::print("\n{}, {} x {}, all methods: seconds; work in sweeps over the full resolution\n{}", scene.name,
               scene.extent().width, scene.extent().height, table_.text());
  }

private:
  static std::vector<Table::Column> columns(std::span<const Backend* const> backends) {
    std::vector<Table::Column> titles{"<method", "effort", "work"};
    for (const Backend* backend : backends) {
      titles.push_back({std::string(backend->name())});
    }
    return titles;
  }

  Table table_;
};

/// The backends to run on an image, the reference first where there is one.
struct Selection {
  std::vector<const Backend*> backends;
  bool checked = true;
};

Selection select_backends(const Arguments& arguments, const std::vector<std::unique_ptr<Backend>>& registry,
                          Extent extent) {
  Selection selection{.backends = arguments.choose(registry)}; // scalar first, whether it was named or not
  const Backend* const scalar = registry.front().get();
  const std::string reference = arguments.reference.value_or(
      extent.sites() <= most_sites_for_scalar ? std::string(scalar->name()) : "none");
  if (reference == scalar->name()) {
    return selection;
  }
  selection.checked = reference != "none";
  const bool named = std::ranges::find(arguments.backends, scalar->name()) != arguments.backends.end();
  if (!named) {
    selection.backends.erase(selection.backends.begin());
  }
  if (selection.checked) {
    const Backend* const chosen = &find_backend(registry, reference);
    std::erase(selection.backends, chosen);
    selection.backends.insert(selection.backends.begin(), chosen);
  }
  if (selection.backends.empty()) {
    throw InputError("no backend is left to run; name one with --backends");
  }
  return selection;
}

/// Without its images: all that the schedule's work goes by. Large ones are loaded one at a time, later.
std::optional<Scene> outline_of(const Arguments& arguments, SceneChoice choice) {
  constexpr int enough = 300;
  const std::optional<Extent> wanted = choice.options.size;
  if (wanted && (wanted->width > enough || wanted->height > enough)) {
    choice.options.size = Extent{enough, enough};
  }
  std::optional<Scene> scene = arguments.load(choice);
  if (scene) {
    scene->full.extent = wanted.value_or(scene->full.extent);
    scene->start = VectorField();
  }
  return scene;
}

BenchOptions bench_options(const Arguments& arguments, bool checked) {
  const auto wants = [&](Work work) {
    const auto name = work_names[static_cast<std::size_t>(work)];
    return std::ranges::find(arguments.work, name) != arguments.work.end();
  };
  return {.session = arguments.session,
          .repeats = arguments.repeats,
          .dense = wants(Work::dense),
          .active = wants(Work::active),
          .scaling = arguments.scaling,
          .checked = checked};
}

int run_bench(Arguments& arguments, const std::string& line) {
  require_results_writable(arguments.json);
  require_results_writable(arguments.benchmark_json);
  if (arguments.sizes.empty()) {
    arguments.sizes = arguments.quick ? std::vector<std::string>{"300", "600"}
                                      : std::vector<std::string>{"300", "600", "1200"};
  }
  const auto registry = make_backends();
  std::vector<SceneChoice> choices;
  double work = 0.0;
  for (const SceneChoice& choice : arguments.scene_choices(published_scenes())) {
    if (const std::optional<Scene> outline = outline_of(arguments, choice)) {
      const Selection selection = select_backends(arguments, registry, outline->extent());
      const auto runs = bench_runs(*outline, selection.backends, bench_options(arguments, selection.checked));
      work += site_updates(*outline) * arguments.repeats * static_cast<double>(runs.size());
      choices.push_back(choice);
    }
  }
  Progress progress;
  progress.set_total(work, WorkUnit::site_updates);
  fmt::print("Seconds are medians of {} samples of a whole solution without set-up{}.\n", arguments.repeats,
             arguments.quick ? " (quick: sizes 300 and 600 only unless others were asked for)" : "");

  nlohmann::json rows = nlohmann::json::array();
  bool all_agree = true;
  bool all_ran = true; // of those whose device is there
  MeasuredCeilings ceilings;
  std::optional<MethodTable> by_method;
  std::set<std::string> chosen; // lines; each backend measures once
  for (std::size_t i = 0; i < choices.size(); ++i) {
    const std::size_t resident = resident_bytes();
    const std::optional<Extent> size = choices[i].options.size;
    progress.describe(fmt::format("prepare {}{}", choices[i].name,
                                  size ? fmt::format(", {} x {}", size->width, size->height) : ""));
    std::optional<Scene> scene = arguments.load(choices[i]);
    if (!scene) { // its file has gone since
      continue;
    }
    const Selection selection = select_backends(arguments, registry, scene->extent());
    BenchOptions options = bench_options(arguments, selection.checked);
    options.ceilings = arguments.no_ceilings ? nullptr : &ceilings;
    options.resident_before_scene = resident;
    const std::vector<BenchResult> results = bench(*scene, selection.backends, options, progress);
    progress.clear();
    print_scene(*scene, results, !arguments.no_ceilings);
    if (!selection.checked) {
      fmt::print("  the fields of this size were not compared: --reference scalar does that, slowly\n");
    }
    if (!arguments.methods.empty()) {
      if (!by_method) {
        by_method.emplace(selection.backends);
      }
      by_method->add(*scene, results);
      const bool last = i + 1 == choices.size() || choices[i + 1].name != choices[i].name ||
                        choices[i + 1].options.size != choices[i].options.size;
      if (last) {
        by_method->print(*scene);
        by_method.reset();
      }
    }
    std::fflush(stdout); // into a pipe too: the next scene may take long
    for (const BenchResult& result : results) {
      for (const Choice& choice : result.choices) {
        chosen.insert(fmt::format("  {}, {}: {}\n", result.backend, result.device.name, describe(choice)));
      }
      rows.push_back(bench_row(*scene, result));
      all_agree = all_agree && (result.valid || result.reference.empty());
      all_ran = all_ran && (!result.samples.empty() || result.device.name.empty());
    }
  }
  if (!chosen.empty()) {
    fmt::print("\nChosen by measurement, medians\n{}", fmt::join(chosen, ""));
  }
  const Context context = run_context(line, arguments.quick);
  report::write_google_benchmark(arguments.benchmark_json, context, rows);
  write_results(arguments.json, "bench", context, std::move(rows));
  if (!all_agree) {
    return disagreement;
  }
  return all_ran ? success : bad_input;
}

} // namespace

void add_bench(const Command& program, const std::string& arguments, int& status, Ranks* ranks) {
  const Command command = program.add_subcommand(
      "bench",
      "Time whole solutions on every backend: Tables 5.2, 5.4, 5.6 and 5.8 of the thesis by default.\n"
      "A field that is not scalar's to the bit gets no speed-up and exit status 1. What the devices can do "
      "at\n"
      "most, in copying memory and in arithmetic, is measured in the same run.");
  const auto own = std::make_shared<Arguments>();
  own->schedule.takes_elastic = true;
  own->add_to(command);
  command.add_option("--repeat", own->repeats, "Samples per backend, scene and size")
      .range(1, 1'000'000)
      .capture_default_str();
  command
      .add_option("--work", own->work,
                  "dense: every sweep visits all sites; active: it leaves out what cannot change, with the "
                  "same bits, where the schedule allows it")
      .delimiter(',')
      .one_of({"dense", "active"})
      .capture_default_str();
  command.add_flag(
      "--scaling,--threads-sweep", own->scaling,
      "Backends with threads of their own run with 1, 2, 4 ... of them, too; with mpirun, followed "
      "by strong or weak: 1, 2, 4 ... ranks");
  command.add_flag("--no-ceilings", own->no_ceilings,
                   "Do not measure what the devices can do at most: a second or two less for each");
  command.add_option("--reference", own->reference,
                     "Backend whose field and time the others are compared with, or none (default: scalar, "
                     "none for images larger than 4096 x 4096)");
  command.add_option(
      "--benchmark-json", own->benchmark_json,
      "Write the samples to this file as Google Benchmark's JSON, too, for its compare.py and for CI");
  const auto comparison = std::make_shared<CompareArguments>();
  comparison->add_to(command);
  const auto gates = std::make_shared<Gates>();
  gates->add_to(command);
  command.callback([own, comparison, gates, command, arguments, &status, ranks] {
    gates->prepare(*own);
    if (ranks != nullptr) {
      status = bench_scaling_on_ranks(*own, own->scaling, own->repeats, arguments, *ranks);
      return;
    }
    const int repeats = command.count("--repeat") > 0 ? own->repeats : 0;
    status = comparison->before.empty() ? run_bench(*own, arguments)
                                        : compare_benches(*comparison, repeats, own->json);
    status = gates->judge(status, *own);
  });
}

} // namespace hdmbench::commands
