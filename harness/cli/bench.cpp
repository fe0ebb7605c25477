#include "harness/measure/bench.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/measure/comparison.hpp"
#include "harness/measure/median.hpp"
#include "harness/measure/memory_use.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/report/ci_files.hpp"
#include "harness/solve/methods/solver.hpp"

#include <cmath>
#include <cstdio>
#include <limits>

namespace hdmbench::commands {

namespace {

const Option<std::vector<std::string>> work("--work",
                                            "dense: every sweep visits all sites; active: it leaves out what "
                                            "cannot change, with the same bits, where the schedule allows it",
                                            {"dense", "active"}, CLI::IsMember({"dense", "active"}));
const Option<bool> scaling("--scaling", "Backends with threads of their own run with 1, 2, 4 ... of them, "
                                        "too; with mpirun, followed by strong or weak: 1, 2, 4 ... ranks");
const Option<bool>
    no_ceilings("--no-ceilings",
                "Do not measure what the devices can do at most: a second or two less for each");
const Option<std::string> reference_name("--reference",
                                         "Backend whose field and time the others are compared with, or none "
                                         "(default: scalar, none for images larger than 4096 x 4096)");
const Option<OutputFile> benchmark_json(
    "--benchmark-json",
    "Write the samples to this file as Google Benchmark's JSON, too, for its compare.py and for CI");
const Option<std::filesystem::path>
    before_file("--compare", "Measure again what this result file has, and compare; nothing else is run");
const Option<std::filesystem::path> after_file("--with",
                                               "Compare with this result file in place of measuring");
const Option<double> tolerance("--tolerance", "Percent by which a time may grow", 5.0,
                               CLI::Range(0.1, 1000.0));

/// Scalar takes minutes for one solution of an image larger than this.
constexpr std::size_t most_sites_for_scalar = std::size_t{4096} * 4096;

/// The scenes of Tables 5.2, 5.4, 5.6 and 5.8.
std::vector<std::string> published_scenes() {
  std::vector<std::string> scenes;
  for (const json& row : published()["timings"]) {
    const auto scene = row["scene"].get<std::string>();
    if (!contains(scenes, scene)) {
      scenes.push_back(scene);
    }
  }
  return scenes;
}

/// `rows`: as bench() has them.
void print_scene(const Scene& scene, const json& rows) {
  const Extent extent = scene.extent();
  const auto ran = std::ranges::find_if(rows, [](const json& row) { return !row["seconds"].empty(); });
  const json& some = ran == rows.end() ? rows.front() : *ran;
  fmt::print("\n{}, {}: {}, {} iterations, {:.4g} million site updates\n", scene.name, extent.text(),
             method_name(scene), some["iterations"].get<std::int64_t>(),
             some["fine_sweep_equivalents"].get<double>() * static_cast<double>(extent.sites()) * 1e-6);
  const bool as_published =
      scene.energy->of_sites == &thesis_energy && extent.axes() == 2 && extent.width == extent.height;
  for (const json& row : published()["timings"]) {
    if (as_published && row["scene"] == scene.name && row["size"] == extent.width) {
      fmt::print("{}", row_text("  thesis, table {table}: GPU {gpu_seconds} s, CPU {cpu_seconds} s, "
                                "speed-up {speed_up}\n",
                                row));
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
      fmt::print("{}", row_text("  {backend}, {work}: no speed-up: {reason}\n", row));
    }
  }
  std::fflush(stdout); // into a pipe too: the next scene may take long
}

/// With the backends to run on an image of this extent, the reference first where there is one.
BenchOptions bench_options(const Call& call, const std::vector<std::unique_ptr<Backend>>& registry,
                           Extent extent, std::vector<const Backend*>& backends) {
  const std::string compared =
      call[reference_name].empty() && extent.sites() > most_sites_for_scalar ? "none" : call[reference_name];
  backends = choose_backends(call, registry, compared);
  const auto wants = [&](Work one) {
    return contains(call[work], work_names[static_cast<std::size_t>(one)]);
  };
  return {.session = call.session(),
          .repeats = call[option::repeat],
          .dense = wants(Work::dense),
          .active = wants(Work::active),
          .scaling = call[scaling],
          .checked = compared != "none"};
}

int measure_scenes(Call& call) {
  if (call[option::sizes].empty()) {
    call[option::sizes] = {"300", "600"};
    call[option::sizes].resize(call[option::quick] ? 2 : 3, "1200");
  }
  const auto registry = make_backends();
  std::vector<const Backend*> backends;
  Progress progress;
  fmt::print("Seconds are medians of {} samples of a whole solution without set-up{}.\n",
             call[option::repeat],
             call[option::quick] ? " (quick: sizes 300 and 600 only unless others were asked for)" : "");

  json rows = json::array();
  bool all_agree = true;
  bool all_ran = true; // of those whose device is there
  MeasuredCeilings ceilings;
  for (const SceneLoader& load : scene_loaders(call, published_scenes())) {
    const std::size_t resident = resident_bytes();
    progress.describe("prepare a scene");
    std::optional<Scene> scene = load();
    if (!scene) {
      continue;
    }
    BenchOptions options = bench_options(call, registry, scene->extent(), backends);
    options.ceilings = call[no_ceilings] ? nullptr : &ceilings;
    options.resident_before_scene = resident;
    const json own = bench(*scene, backends, options, progress);
    progress.clear();
    for (const json& row : own) {
      all_agree = all_agree && (row["valid"] == true || row["reference"].is_null());
      all_ran = all_ran && (!row["seconds"].empty() || row["device"] == "");
    }
    print_scene(*scene, own);
    if (!options.checked) {
      fmt::print("  the fields were not checked against scalar: --reference scalar does that, slowly\n");
    }
    rows.insert(rows.end(), own.begin(), own.end());
  }
  report::write_google_benchmark(call[benchmark_json], run_context(call.line, call[option::quick]), rows);
  call.write(std::move(rows));
  return !all_agree ? disagreement : all_ran ? success : bad_input;
}

ResultFile read_bench(const std::filesystem::path& file) {
  ResultFile results = read_results(file);
  if (results.command != "bench" || results.results.empty()) {
    throw InputError(
        fmt::format("{}: has no timings; hdmbench bench --json FILE writes them", file.string()));
  }
  return results;
}

/// What the command line of a result file measures now, written to `file`.
ResultFile measure_again(const std::string& line, int repeats, const std::filesystem::path& file) {
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

/// `bench --compare`: two result files, or one with what its own command line measures now, with `repeats`
/// samples; whose results then go to --json. Prints a line for every timing of before. Returns the
/// ExitStatus: disagreement where one is slower, inconclusive, missing or of another device. Throws
/// InputError.
int compare_benches(const Call& call, int repeats) {
  const ResultFile before = read_bench(call[before_file]);
  const TemporaryDirectory folder;
  const ResultFile after =
      !call[after_file].empty()
          ? read_bench(call[after_file])
          : measure_again(before.context.arguments, repeats,
                          call[option::json].empty() ? OutputFile((folder.path() / "bench.json").string())
                                                     : call[option::json]);
  const json rows = compare_results(before, after, call[tolerance] / 100.0);
  if (rows.empty()) {
    throw InputError(fmt::format("{}: has no valid timing to compare with", call[before_file].string()));
  }
  const auto passing = std::ranges::count_if(rows, [](const json& row) { return row["passes"].get<bool>(); });
  for (const ResultFile* const file : {&before, &after}) {
    const Context& context = file->context;
    fmt::print("{}: commit {}, {}, {}, {}\n", file == &before ? "old" : "new", context.commit,
               context.compiler, context.machine, context.date);
  }
  fmt::print("\n{}\n{} of {} timings are not slower by more than {:.3g} % (medians; Mann-Whitney, one-sided, "
             "p < {:g})\n",
             table_text(rows, "scene|size|backend|method|threads|old_s|new_s|ratio:new/old|p|verdict"),
             passing, rows.size(), call[tolerance], significant_p);
  return passing == std::ssize(rows) ? success : disagreement;
}

/// With sides `factor` times as long, multiples of 4.
Extent scaled(Extent extent, double factor) {
  const auto side = [&](int sites) {
    return factor == 1.0 ? sites : 4 * static_cast<int>(std::lround(sites * factor / 4.0));
  };
  return {side(extent.width), side(extent.height)};
}

/// A row of results: samples of whole solutions without making the scene and opening sessions, and messages
/// and bytes of all ranks in one of them. "message_seconds" are those of the rank that was the longest in
/// messages, the least of the samples. Collective.
json measure_on_ranks(const Scene& scene, const std::string& kind, const RankBackend& backend, int repeats,
                      Ranks& ranks) {
  json row = with_size({{"scene", scene.name},
                        {"energy", scene.energy->name},
                        {"scaling", kind},
                        {"backend", backend.backends()},
                        {"ranks", backend.ranks()},
                        {"seconds", json::array()}},
                       scene.extent());
  Progress silent(false);
  Solver solver(backend, {});
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= repeats; ++i) { // the first time is slower: shaders are compiled, memory is new
    const Traffic before = ranks.traffic();
    const double seconds = ranks.largest(solver.solve(scene, silent).timings.total());
    row["messages"] = ranks.sum(ranks.traffic().messages - before.messages);
    row["bytes"] = ranks.sum(ranks.traffic().bytes - before.bytes);
    const double in_messages = ranks.largest(ranks.traffic().seconds - before.seconds);
    if (i > 0) {
      row["seconds"].push_back(seconds);
      least = std::min(least, in_messages);
    }
  }
  row["message_seconds"] = least;
  return row;
}

/// The rows, each with what it comes to beside the first one in place of its samples.
json judged(json rows) {
  const double pixels = rows[0]["width"].get<double>() * rows[0]["height"].get<double>();
  const double first = median(rows[0]["seconds"].get<std::vector<double>>());
  for (json& row : rows) {
    const double seconds = median(row["seconds"].get<std::vector<double>>());
    const double speed_up =
        row["width"].get<double>() * row["height"].get<double>() / pixels * first / seconds;
    row.update({{"seconds", seconds},
                {"speed-up", speed_up},
                {"efficiency", speed_up / row["ranks"].get<double>()}});
  }
  return rows;
}

/// `bench --scaling strong|weak` on ranks: the same image on 1, 2, 4 ... of them, or an image that grows with
/// them. "strong" or "weak" stands before the scenes. Returns an ExitStatus.
int bench_on_ranks(const Call& call, Ranks& ranks) {
  const std::string kind = call[option::scenes].empty() ? "" : call[option::scenes].front();
  if (!call[scaling] || (kind != "strong" && kind != "weak")) {
    throw InputError("on several ranks: bench --scaling strong (the same image on more ranks) or bench "
                     "--scaling weak (an image that grows with them), then a scene");
  }
  if (call[option::scenes].size() > 2 || call[option::sizes].size() > 1 ||
      call[option::backends].size() > 1) {
    throw InputError("bench --scaling on ranks takes one scene, one size and one backend");
  }
  const Extent size =
      call[option::sizes].empty() ? Extent{1024, 1024} : parse_size(call[option::sizes].front());
  const std::string name = call[option::scenes].size() > 1 ? call[option::scenes][1] : "square";
  const std::string backends = call[option::backends].empty() ? "openmp" : call[option::backends].front();
  const auto registry = make_backends();
  Progress progress(ranks.is_first());
  json rows = json::array();
  for (int count = 1; count <= ranks.size();) { // 1, 2, 4 ... and all
    progress.describe(fmt::format("{} ranks", count));
    Scene scene = load_scene(name, {.size = kind == "weak" ? scaled(size, std::sqrt(count)) : size});
    call.schedule.apply(scene);
    const RankBackend backend(ranks, registry, backends, call.session(), {.pieces = count});
    rows.push_back(measure_on_ranks(scene, kind, backend, call[option::repeat], ranks));
    count = count == ranks.size() ? count + 1 : std::min(2 * count, ranks.size());
  }
  progress.clear();
  if (!ranks.is_first()) {
    return success;
  }
  fmt::print(
      "{} scaling, {} on 1 ... {} ranks of this run; medians of {} samples, without making the scene "
      "and opening sessions\n{}"
      "  in messages: the rank that was the longest in them, with waiting for others, the least of the "
      "samples\n",
      kind, backends, ranks.size(), call[option::repeat],
      table_text(judged(rows), "ranks|size|seconds|speed-up|efficiency|messages|bytes:bytes sent|"
                               "message_seconds:s in messages"));
  call.write(std::move(rows), "scaling");
  return success;
}

int run_bench(Call& call) {
  const Gates gates(call);
  if (call.ranks != nullptr) {
    return bench_on_ranks(call, *call.ranks);
  }
  constexpr int enough_samples = 10; // for the test, even beside the three that bench takes by default
  const bool is_told = call.command->count("--repeat") > 0;
  return gates.judge(call[before_file].empty()
                         ? measure_scenes(call)
                         : compare_benches(call, is_told ? call[option::repeat] : enough_samples),
                     call);
}

} // namespace

void add_bench(CLI::App& program, Call& call) {
  add_command(
      program, call, "bench", run_bench,
      "Time every backend on whole solutions and compare with the thesis: Tables 5.2, 5.4, 5.6 and 5.8 at\n"
      "300, 600 and 1200 by default. Speed-ups are over scalar, one thread at -O2, in the same run; a\n"
      "backend whose field is not scalar's to the bit gets no speed-up and exit status 1. What the devices\n"
      "can do at most, in copying memory and in arithmetic, is measured in the same run.",
      {comparison_options(), option::repeat, work, scaling, no_ceilings, reference_name, benchmark_json,
       Options{before_file, after_file, tolerance}.under(
           "Compare with before (exit status 1: slower, inconclusive, missing, other device)"),
       gate_options()},
      {"--methods excludes --method", "--with needs --compare", "--with excludes --json",
       "--tolerance needs --compare"});
}

} // namespace hdmbench::commands
