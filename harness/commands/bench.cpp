#include "harness/bench.hpp"

#include "harness/commands/arguments.hpp"
#include "harness/commands/bench_compare.hpp"
#include "harness/commands/commands.hpp"
#include "harness/context.hpp"
#include "harness/file_output.hpp"
#include "harness/table.hpp"
#include "reference/published.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace hdmbench::commands {

namespace {

struct Arguments : CommonArguments {
  int repeats = 3;
};

double total(const Timings& timings) {
  return timings.total();
}
double projection(const Timings& timings) {
  return timings.projection;
}
double upload(const Timings& timings) {
  return timings.upload;
}
double compute(const Timings& timings) {
  return timings.compute;
}
double readback(const Timings& timings) {
  return timings.readback;
}

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

/// 10^6 site updates per second of compute; 0 without samples.
double msites_per_second(const BenchResult& result) {
  const double seconds = median_seconds(result.samples, compute);
  return seconds > 0.0 ? result.site_updates / seconds * 1e-6 : 0.0;
}

nlohmann::json to_json(const Scene& scene, const BenchResult& result) {
  nlohmann::json seconds = nlohmann::json::array();
  std::ranges::transform(result.samples, std::back_inserter(seconds), total);
  return {{"scene", scene.name},
          {"width", scene.extent().width},
          {"height", scene.extent().height},
          {"backend", result.backend},
          {"device", result.device.name},
          {"method", method_name(scene.schedule)},
          {"effort", scene.schedule.iterations},
          {"iterations", result.iterations},
          {"fine_sweep_equivalents", result.site_updates / static_cast<double>(scene.extent().sites())},
          {"seconds", seconds},
          {"seconds_median", median_seconds(result.samples, total)},
          {"msites_per_second", msites_per_second(result)},
          {"setup_seconds", result.setup_seconds},
          {"projection_seconds", median_seconds(result.samples, projection)},
          {"upload_seconds", median_seconds(result.samples, upload)},
          {"compute_seconds", median_seconds(result.samples, compute)},
          {"readback_seconds", median_seconds(result.samples, readback)},
          {"speed_up_over_scalar", result.speed_up ? nlohmann::json(*result.speed_up) : nlohmann::json()},
          {"valid", result.valid},
          {"reason", result.reason}};
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

void print_scene(const Scene& scene, const std::vector<BenchResult>& results) {
  const BenchResult& reference = results.front();
  fmt::print("\n{}, {} x {}: {}, {} iterations, {:.4g} million site updates\n", scene.name,
             scene.extent().width, scene.extent().height, method_name(scene.schedule), reference.iterations,
             reference.site_updates * 1e-6);
  const PublishedTiming* published = scene.extent().width == scene.extent().height
                                         ? published_timing(scene.name, scene.extent().width)
                                         : nullptr;
  if (published != nullptr) {
    fmt::print("  thesis, table {}: GPU {} s, CPU {} s, speed-up {}\n", published->table,
               published->gpu_seconds, published->cpu_seconds, published->speed_up);
  }
  Table table({{"backend", Table::Align::left},
               {"seconds", Table::Align::right},
               {"min", Table::Align::right},
               {"max", Table::Align::right},
               {"projection", Table::Align::right},
               {"upload", Table::Align::right},
               {"compute", Table::Align::right},
               {"readback", Table::Align::right},
               {"set-up", Table::Align::right},
               {"Msites/s", Table::Align::right},
               {"speed-up", Table::Align::right}});
  std::string remarks;
  for (const BenchResult& result : results) {
    if (!result.valid) {
      remarks += fmt::format("  {}: no speed-up: {}\n", result.backend, result.reason);
    }
    if (result.samples.empty()) {
      continue;
    }
    const auto [fastest, slowest] = std::ranges::minmax_element(result.samples, {}, total);
    const auto part = [&](double (*which)(const Timings&)) {
      return seconds_text(median_seconds(result.samples, which));
    };
    table.add({result.backend, part(total), seconds_text(fastest->total()), seconds_text(slowest->total()),
               part(projection), part(upload), part(compute), part(readback),
               seconds_text(result.setup_seconds), fmt::format("{:.1f}", msites_per_second(result)),
               result.speed_up ? fmt::format("{:.2f}", *result.speed_up) : "-"});
  }
  fmt::print("{}{}", table.text(), remarks);
}

/// One line per method of --methods on one scene.
class MethodTable {
public:
  explicit MethodTable(std::span<const Backend* const> backends) : table_(columns(backends)) {}

  void add(const Scene& scene, const std::vector<BenchResult>& results) {
    const double work = results.front().site_updates / static_cast<double>(scene.extent().sites());
    std::vector<std::string> cells{method_name(scene.schedule), std::to_string(scene.schedule.iterations),
                                   results.front().samples.empty() ? "-" : fmt::format("{:.2f}", work)};
    for (const BenchResult& result : results) {
      cells.push_back(result.valid             ? seconds_text(median_seconds(result.samples, total))
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
    std::vector<Table::Column> titles{{"method", Table::Align::left}, {"effort"}, {"work"}};
    for (const Backend* backend : backends) {
      titles.push_back({std::string(backend->name())});
    }
    return titles;
  }

  Table table_;
};

int run_bench(Arguments& arguments, const std::string& line) {
  if (!arguments.json.empty()) {
    require_writable(arguments.json);
  }
  if (arguments.sizes.empty()) {
    arguments.sizes = arguments.quick ? std::vector<std::string>{"300", "600"}
                                      : std::vector<std::string>{"300", "600", "1200"};
  }
  const auto registry = make_backends();
  const std::vector<const Backend*> backends = arguments.choose(registry);
  const std::vector<Scene> scenes = arguments.load_scenes(published_scenes());
  Progress progress;
  double work = 0.0;
  for (const Scene& scene : scenes) {
    work += site_updates(scene);
  }
  progress.set_total(work * arguments.repeats * static_cast<double>(backends.size()));
  fmt::print("Seconds are medians of {} samples of a whole solution without set-up{}.\n", arguments.repeats,
             arguments.quick ? " (quick: sizes 300 and 600 only unless others were asked for)" : "");

  nlohmann::json rows = nlohmann::json::array();
  bool all_agree = true;
  bool all_ran = true; // of those whose device is there
  std::optional<MethodTable> by_method;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const Scene& scene = scenes[i];
    const std::vector<BenchResult> results =
        bench(scene, backends, {.session = arguments.session, .repeats = arguments.repeats}, progress);
    progress.clear();
    print_scene(scene, results);
    if (!arguments.methods.empty()) {
      if (!by_method) {
        by_method.emplace(backends);
      }
      by_method->add(scene, results);
      const bool last = i + 1 == scenes.size() || scenes[i + 1].source != scene.source ||
                        scenes[i + 1].extent() != scene.extent();
      if (last) {
        by_method->print(scene);
        by_method.reset();
      }
    }
    std::fflush(stdout); // into a pipe too: the next scene may take long
    for (const BenchResult& result : results) {
      rows.push_back(to_json(scene, result));
      all_agree = all_agree && (result.valid || result.samples.empty());
      all_ran = all_ran && (!result.samples.empty() || result.device.name.empty());
    }
  }
  if (!arguments.json.empty()) {
    write_results(arguments.json, "bench", run_context(line, arguments.quick), std::move(rows));
  }
  if (!all_agree) {
    return disagreement;
  }
  return all_ran ? success : bad_input;
}

} // namespace

void add_bench(CLI::App& program, const std::string& arguments, int& status) {
  auto* command = program.add_subcommand(
      "bench",
      "Time whole solutions on every backend: Tables 5.2, 5.4, 5.6 and 5.8 of the thesis by default.\n"
      "A field that is not scalar's to the bit gets no speed-up and exit status 1.");
  const auto own = std::make_shared<Arguments>();
  own->add_to(*command);
  command->add_option("--repeat", own->repeats, "Samples per backend, scene and size")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  const auto comparison = std::make_shared<CompareArguments>();
  comparison->add_to(*command);
  command->callback([own, comparison, command, arguments, &status] {
    const int repeats = command->count("--repeat") > 0 ? own->repeats : 0;
    status = comparison->wanted() ? compare_benches(*comparison, *command, arguments, repeats, own->json)
                                  : run_bench(*own, arguments);
  });
}

} // namespace hdmbench::commands
