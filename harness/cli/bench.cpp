#include "harness/measure/bench.hpp"

#include "harness/cli/bench.hpp"
#include "harness/measure/memory_use.hpp"
#include "harness/report/ci_files.hpp"
#include "harness/report/published.hpp"
#include "harness/scene/method.hpp"

#include <cstdio>

namespace hdmbench::commands {

namespace {

/// Scalar takes minutes for one solution of an image larger than this.
constexpr std::size_t most_sites_for_scalar = std::size_t{4096} * 4096;

/// The scenes of Tables 5.2, 5.4, 5.6 and 5.8.
std::vector<std::string> published_scenes() {
  std::vector<std::string> scenes;
  for (const json& row : published()["timings"]) {
    const auto scene = row["scene"].get<std::string>();
    if (std::ranges::find(scenes, scene) == scenes.end()) {
      scenes.push_back(scene);
    }
  }
  return scenes;
}

/// `rows`: as bench_row() has them.
void print_scene(const Scene& scene, const std::vector<BenchResult>& results, const json& rows) {
  const Extent extent = scene.extent();
  const auto ran = std::ranges::find_if(results, [](const auto& one) { return !one.samples.empty(); });
  const BenchResult& some = ran == results.end() ? results.front() : *ran;
  fmt::print("\n{}, {} x {}: {}, {} iterations, {:.4g} million site updates\n", scene.name, extent.width,
             extent.height, method_name(scene), some.iterations, some.site_updates * 1e-6);
  const bool as_published = scene.energy->of_sites == &thesis_energy && extent.width == extent.height;
  for (const json& row : published()["timings"]) {
    if (as_published && row["scene"] == scene.name && row["size"] == extent.width) {
      fmt::print("  thesis, table {}: GPU {} s, CPU {} s, speed-up {}\n", row["table"].get<std::string>(),
                 row["gpu_seconds"].get<double>(), row["cpu_seconds"].get<double>(),
                 row["speed_up"].get<double>());
    }
  }
  json timed = rows;
  std::erase_if(timed.get_ref<json::array_t&>(), [](const json& row) { return row["seconds"].empty(); });
  fmt::print("{}",
             table_text(timed, "backend|work|threads|seconds_median:seconds|projection_seconds:projection|"
                               "upload_seconds:upload|compute_seconds:compute|readback_seconds:readback|"
                               "setup_seconds:set-up|msites_per_second:Msites/s|bytes_per_site:bytes/site|"
                               "speed_up_over_scalar:speed-up|speed_up_over_dense:over dense|"
                               "percent_of_ceiling:% of ceiling|binding:bound by"));
  for (const json& row : rows) {
    if (row["valid"] == false) {
      fmt::print("  {}, {}: no speed-up: {}\n", row["backend"].get<std::string>(),
                 row["work"].get<std::string>(), row["reason"].get<std::string>());
    }
  }
  std::fflush(stdout); // into a pipe too: the next scene may take long
}

/// With the backends to run on an image of this extent, the reference first where there is one.
BenchOptions bench_options(const BenchArguments& arguments,
                           const std::vector<std::unique_ptr<Backend>>& registry, Extent extent,
                           std::vector<const Backend*>& backends) {
  const std::string reference =
      arguments.reference.empty() && extent.sites() > most_sites_for_scalar ? "none" : arguments.reference;
  backends = arguments.choose(registry, reference);
  const auto wants = [&](Work work) {
    const auto name = work_names[static_cast<std::size_t>(work)];
    return std::ranges::find(arguments.work, name) != arguments.work.end();
  };
  return {.session = arguments.session,
          .repeats = arguments.repeats,
          .dense = wants(Work::dense),
          .active = wants(Work::active),
          .scaling = arguments.scaling,
          .checked = reference != "none"};
}

int measure_scenes(BenchArguments& arguments, const Call& call) {
  if (arguments.sizes.empty()) {
    arguments.sizes = {"300", "600"};
    arguments.sizes.resize(arguments.quick ? 2 : 3, "1200");
  }
  const auto registry = make_backends();
  std::vector<const Backend*> backends;
  Progress progress;
  fmt::print("Seconds are medians of {} samples of a whole solution without set-up{}.\n", arguments.repeats,
             arguments.quick ? " (quick: sizes 300 and 600 only unless others were asked for)" : "");

  json rows = json::array();
  bool all_agree = true;
  bool all_ran = true; // of those whose device is there
  MeasuredCeilings ceilings;
  for (const SceneLoader& load : arguments.scene_loaders(published_scenes())) {
    const std::size_t resident = resident_bytes();
    progress.describe("prepare a scene");
    std::optional<Scene> scene = load();
    if (!scene) {
      continue;
    }
    BenchOptions options = bench_options(arguments, registry, scene->extent(), backends);
    options.ceilings = arguments.no_ceilings ? nullptr : &ceilings;
    options.resident_before_scene = resident;
    const std::vector<BenchResult> results = bench(*scene, backends, options, progress);
    progress.clear();
    json own = json::array();
    for (const BenchResult& result : results) {
      own.push_back(bench_row(*scene, result));
      all_agree = all_agree && (result.valid || result.reference.empty());
      all_ran = all_ran && (!result.samples.empty() || result.device.name.empty());
    }
    print_scene(*scene, results, own);
    if (!options.checked) {
      fmt::print("  the fields were not checked against scalar: --reference scalar does that, slowly\n");
    }
    rows.insert(rows.end(), own.begin(), own.end());
  }
  report::write_google_benchmark(arguments.benchmark_json, run_context(call.line, arguments.quick), rows);
  call.write(std::move(rows), arguments.quick);
  return !all_agree ? disagreement : all_ran ? success : bad_input;
}

int run_bench(BenchArguments& arguments, Call& call) {
  arguments.gates.prepare(arguments, call);
  if (call.ranks != nullptr) {
    return bench_on_ranks(arguments, call, *call.ranks);
  }
  constexpr int enough_samples = 10; // for the test, even beside the three that bench takes by default
  const bool is_told = call.command->count("--repeat") > 0;
  return arguments.gates.judge(
      arguments.before.empty()
          ? measure_scenes(arguments, call)
          : compare_benches(arguments, call, is_told ? arguments.repeats : enough_samples),
      call);
}

} // namespace

void add_bench(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "bench",
      "Time every backend on whole solutions and compare with the thesis: Tables 5.2, 5.4, 5.6 and 5.8 at\n"
      "300, 600 and 1200 by default. Speed-ups are over scalar, one thread at -O2, in the same run; a\n"
      "backend whose field is not scalar's to the bit gets no speed-up and exit status 1. What the devices\n"
      "can do at most, in copying memory and in arithmetic, is measured in the same run.",
      run_bench);
  own.schedule.takes_energy = true;
  own.add_to(command, call);
  add_option(command, "--repeat", own.repeats, "Samples per backend, scene and size")
      ->check(CLI::Range(1, 1'000'000));
  add_option(command, "--work", own.work,
             "dense: every sweep visits all sites; active: it leaves out what cannot change, with the "
             "same bits, where the schedule allows it")
      ->delimiter(',')
      ->check(CLI::IsMember({"dense", "active"}));
  add_flag(command, "--scaling", own.scaling,
           "Backends with threads of their own run with 1, 2, 4 ... of them, too; with mpirun, followed "
           "by strong or weak: 1, 2, 4 ... ranks");
  add_flag(command, "--no-ceilings", own.no_ceilings,
           "Do not measure what the devices can do at most: a second or two less for each");
  add_option(command, "--reference", own.reference,
             "Backend whose field and time the others are compared with, or none (default: scalar, "
             "none for images larger than 4096 x 4096)");
  add_output(command, "--benchmark-json", own.benchmark_json,
             "Write the samples to this file as Google Benchmark's JSON, too, for its compare.py and for CI");
  {
    const OptionGroup group(
        command, "Compare with before (exit status 1: slower, inconclusive, missing, other device)");
    CLI::Option* const before =
        add_option(command, "--compare", own.before,
                   "Measure again what this result file has, and compare; nothing else is run");
    add_option(command, "--with", own.after, "Compare with this result file in place of measuring")
        ->needs(before)
        ->excludes("--json");
    add_option(command, "--tolerance", own.tolerance, "Percent by which a time may grow")
        ->needs(before)
        ->check(CLI::Range(0.1, 1000.0));
  }
  own.gates.add_to(command);
}

} // namespace hdmbench::commands
