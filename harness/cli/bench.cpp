#include "harness/measure/bench.hpp"

#include "harness/cli/arguments.hpp"
#include "harness/cli/programs.hpp"
#include "harness/measure/median.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/unloading.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <iterator>
#include <limits>

namespace hdmbench::commands {

namespace {

const Option<std::vector<std::string>> work("--work",
                                            "dense: every sweep visits all sites; active: it leaves out what "
                                            "cannot change, with the same bits, where the schedule allows it",
                                            {"dense", "active"}, CLI::IsMember({"dense", "active"}));
const Option<bool> scaling("--scaling", "Backends with threads of their own run with 1, 2, 4 ... of them, "
                                        "too; with mpirun, followed by strong or weak: 1, 2, 4 ... ranks");
const Option<bool> kernels("--kernels",
                           "Time the steps of the methods by themselves, in place of scenes: 1024x1024 and "
                           "64x64x64 unless --sizes says otherwise, both energies unless --energy does");
const Option<bool>
    no_ceilings("--no-ceilings",
                "Do not measure what the devices can do at most: a second or two less for each");
const Option<std::string> reference_name("--reference",
                                         "Backend whose field and time the others are compared with, or none "
                                         "(default: scalar, none for images larger than 4096 x 4096)");
const Option<OutputFile> benchmark_json("--benchmark-json", "The same as --benchmark_out");

/// What the library was given, word by word; the key of a Call only.
const Option<std::vector<std::string>> library_words("Google Benchmark", "");

/// Flags of Google Benchmark, which takes them as they are.
struct LibraryFlag {
  const char* name;
  const char* takes; ///< empty: nothing
  const char* help;
  double least = 0.0; ///< of a number
  double most = 0.0;  ///< 0: it is no number
};
constexpr std::array library_flags{
    LibraryFlag{"--benchmark_filter", "REGEX", "Only cases whose names have this; -REGEX: have not"},
    LibraryFlag{"--benchmark_list_tests", "", "Name the cases and stop"},
    LibraryFlag{"--benchmark_repetitions", "N", "The same as --repeat", 1.0, 1e6},
    LibraryFlag{"--benchmark_min_time", "SECONDS",
                "A sample is the mean of as many solutions as take so long", 0.0, 1e5},
    LibraryFlag{"--benchmark_enable_random_interleaving", "", "Repetitions of all cases in random order"},
    LibraryFlag{"--benchmark_format", "TEXT", "Print the library's own console, json or csv, not our tables"},
    LibraryFlag{"--benchmark_out", "FILE", "Write the samples to this file, too, for compare.py and CI"},
    LibraryFlag{"--benchmark_out_format", "TEXT", "json, console or csv"},
    LibraryFlag{"--benchmark_report_aggregates_only", "", "Only mean, median, deviation of the repetitions"},
    LibraryFlag{"--benchmark_display_aggregates_only", "", "The same of what is printed"},
    LibraryFlag{"--benchmark_counters_tabular", "", "Counters in columns"},
    LibraryFlag{"--benchmark_color", "TEXT", "auto, true or false"},
    LibraryFlag{"--benchmark_time_unit", "TEXT", "ns, us, ms or s"},
    LibraryFlag{"--benchmark_context", "KEY=VALUE", "Add this to what the library's files say of the run"}};

Options library_options() {
  Options all{};
  for (const LibraryFlag& flag : library_flags) {
    all = {all, Options(flag.name, [flag](CLI::App& command, Call& call) {
             std::vector<std::string>& given = call[library_words];
             const std::function<void(const std::string&)> take = [&given, flag](const std::string& value) {
               const double number = number_of<double>(value).value_or(-1.0);
               if (flag.most > 0.0 && !(number >= flag.least && number <= flag.most)) { // or it never ends
                 throw InputError(
                     fmt::format("{} {}: give {:g} ... {:g}", flag.name, value, flag.least, flag.most));
               }
               given.push_back(fmt::format("{}={}", flag.name, value));
             };
             if (*flag.takes == '\0') {
               command.add_flag_callback(
                   flag.name, [take] { take("true"); }, flag.help);
             } else {
               command.add_option_function(flag.name, take, flag.help)->type_name(flag.takes);
             }
           })};
  }
  return all.under("Google Benchmark's own");
}

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

/// `rows`: those of one scene, as Bench has them.
void print_scene(const json& rows) {
  const auto ran = std::ranges::find_if(rows, [](const json& row) { return !row["seconds"].empty(); });
  const json& some = ran == rows.end() ? rows.front() : *ran;
  const Extent extent{some["width"], some["height"], some.value("depth", 1)};
  const std::string method = some["method"];
  fmt::print("\n{}, {}: {}, {} iterations, {:.4g} million site updates\n", some["scene"].get<std::string>(),
             extent.text(), method.substr(0, method.find("-active")), some["iterations"].get<std::int64_t>(),
             some["fine_sweep_equivalents"].get<double>() * static_cast<double>(extent.sites()) * 1e-6);
  for (const json& row : published()["timings"]) {
    if (some["energy"] == thesis_energy.name && row["scene"] == some["scene"] &&
        extent == Extent{row["size"], row["size"]}) {
      fmt::print("{}", row_text("  thesis, table {table}: GPU {gpu_seconds} s, CPU {cpu_seconds} s, "
                                "speed-up {speed_up}\n",
                                row));
    }
  }
  json timed = rows;
  std::erase_if(timed.get_ref<json::array_t&>(), [](const json& row) { return row["seconds"].empty(); });
  fmt::print("{}", table_text(timed, "backend|work|threads|seconds_median:time|spread_percent:+- %|"
                                     "setup_seconds:set-up|msites_per_second:Msites/s|"
                                     "bytes_per_site:bytes/site|speed_up_over_scalar:speed-up|"
                                     "speed_up_over_dense:over dense|percent_of_ceiling:% ceiling"));
  for (const json& row : rows) {
    if (row["valid"] == false) {
      fmt::print("{}", row_text("  {backend}, {work}: no speed-up: {reason}\n", row));
    }
  }
  if (ran != rows.end() && some["reference"].is_null()) {
    fmt::print("  the fields were not checked against scalar: --reference scalar does that, slowly\n");
  }
  std::fflush(stdout); // into a pipe too: the next scene may take long
}

/// How a scene is timed.
BenchOptions bench_options(const Call& call, const std::vector<std::unique_ptr<Backend>>& registry,
                           const Scene& scene) {
  const std::string compared = call[reference_name].empty() && scene.extent().sites() > most_sites_for_scalar
                                   ? "none"
                                   : call[reference_name];
  const auto wants = [&](Work one) {
    return contains(call[work], work_names[static_cast<std::size_t>(one)]);
  };
  return {.backends = choose_backends(call, registry, compared),
          .session = call.session(),
          .dense = wants(Work::dense),
          .active = wants(Work::active),
          .scaling = call[scaling],
          .checked = compared != "none",
          .ceilings = !call[no_ceilings],
          .command = [&call](const Scene& of, const Backend& backend, const SessionOptions& session) {
            return repeat_line(call, of, backend.name(), session.threads) +
                   fmt::format(" --work {}", work_names.at(static_cast<std::size_t>(session.work))) +
                   (call[reference_name].empty() ? "" : " --reference " + call[reference_name]);
          }};
}

void print_kernels(const json& rows) {
  json timed = rows;
  std::erase_if(timed.get_ref<json::array_t&>(), [](const json& row) { return row["seconds"].empty(); });
  for (json& row : timed) {
    for (const char* const key : {"device_seconds", "launch_seconds"}) {
      row[key] = row[key].is_null() ? json("-") : row[key]; // no clock that tells
    }
  }
  const json& some = timed.empty() ? rows.front() : timed.front();
  const Extent extent{some["width"], some["height"], some.value("depth", 1)};
  fmt::print("\n{}, {}{}", some["energy"].get<std::string>(), extent.text(),
             row_text(", {backend}: {device}\n", some));
  fmt::print("{}",
             table_text(timed, "kernel|level|seconds_median:time|spread_percent:+- %|device_seconds:device|"
                               "launch_seconds:launch|percent_of_ceiling:% ceiling|binding:bound by|"
                               "msites_per_second:Msites/s|gigabytes_per_second:GB/s|"
                               "gigaoperations_per_second:Gop/s"));
  if (some["reason"] != "") {
    fmt::print("{}", row_text("  {kernel} on {backend}: {reason}\n", some));
  }
  std::fflush(stdout);
}

/// `bench --kernels`.
void add_kernels(const Call& call, const std::vector<std::unique_ptr<Backend>>& registry, Bench& bench) {
  const std::vector<std::string> usual{"1024x1024", "64x64x64"};
  const bool all = call.schedule.energy == nullptr;
  for (const std::string& size : call[option::sizes].empty() ? usual : call[option::sizes]) {
    for (const bool elastic : {false, true}) {
      if (all || call.schedule.energy->is_of_cells() == elastic) {
        bench.add_kernels(
            {.options = {.backends = choose_backends(call, registry, needs(call, "scalar") ? "" : "none"),
                         .session = call.session(),
                         .checked = false,
                         .ceilings = !call[no_ceilings]},
             .elastic = elastic,
             .extent = parse_size(size)});
      }
    }
  }
}

/// The words for the library: what is usual here, then what the user wants.
std::vector<std::string> words_for_library(const Call& call) {
  std::vector<std::string> words{fmt::format("--benchmark_repetitions={}", call[option::repeat]),
                                 "--benchmark_min_time=0.02"};
  if (!call[benchmark_json].empty()) {
    words.push_back(fmt::format("--benchmark_out={}", call[benchmark_json].string()));
  }
  words.insert(words.end(), call[library_words].begin(), call[library_words].end());
  return words;
}

/// Sizes where the command line names none; none of scenes that have the pixels of their files, which are
/// measured as they are.
std::vector<std::string> usual_sizes(const Call& call) {
  const std::vector<std::string>& scenes = call[option::scenes];
  const auto count = [&](bool (*is_meant)(const std::string&)) {
    return static_cast<std::size_t>(std::ranges::count_if(scenes, is_meant));
  };
  const std::size_t of_files = count(has_pixels_of_files);
  const std::size_t volumes = count(states_volume);
  if (of_files > 0 && of_files == scenes.size()) {
    return {};
  }
  if (volumes == 0 && of_files == 0) {
    return call[option::quick] ? std::vector<std::string>{"300", "600"}
                               : std::vector<std::string>{"300", "600", "1200"};
  }
  if (volumes < scenes.size()) {
    throw InputError("the scenes have no sizes in common: measure one of them, or give --sizes");
  }
  return call[option::quick] ? std::vector<std::string>{"64x64x64"}
                             : std::vector<std::string>{"64x64x64", "128x128x128"};
}

int measure_scenes(Call& call) {
  if (call[option::sizes].empty() && !call[kernels]) {
    call[option::sizes] = usual_sizes(call);
  }
  const auto registry = make_backends();
  Progress progress;
  Bench bench(progress);
  call.schedule.takes_boxes = true;
  if (call[kernels]) {
    refuse_idle(*call.command, {"--work", "--scaling", "--reference", "--method", "--methods"},
                "it belongs to whole solutions, not to --kernels");
    add_kernels(call, registry, bench);
  }
  for (const SceneLoader& load :
       call[kernels] ? std::vector<SceneLoader>() : scene_loaders(call, published_scenes())) {
    bench.add(load, [&](const Scene& scene) { return bench_options(call, registry, scene); });
  }
  progress.clear();
  if (!call[against].empty()) {
    return compare_programs(call, bench.registered());
  }
  fmt::print(
      "{} +- is half of what the samples differ by.{}\n",
      call[kernels]
          ? "Time of one of several steps that are waited for together: \"device\" by the device's own\n"
            "clock, \"launch\" the rest."
          : "Medians of whole solutions without set-up;",
      call[option::quick] && !call[kernels] ? "\nQuick: the smaller sizes only unless others were asked for."
                                            : "");
  tell_library(run_context(call.line, call[option::quick]));
  json rows = bench.run(words_for_library(call), stdout == stderr ? std::cerr : std::cout,
                        {.show = call[kernels] ? print_kernels : print_scene,
                         .keep = [&](const json& some) { call.keep(some); }});
  if (rows.empty()) { // the library named its cases
    return success;
  }
  const bool all_agree = std::ranges::all_of(
      rows, [](const json& row) { return row["valid"] == true || row["reference"].is_null(); });
  const bool all_ran = std::ranges::all_of( // of those whose device is there
      rows, [](const json& row) { return !row["seconds"].empty() || row["device"] == ""; });
  call.write(std::move(rows));
  return !all_agree ? disagreement : all_ran ? success : bad_input;
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
  const std::string name = call[option::scenes].size() > 1 ? call[option::scenes][1] : "square";
  const Extent size =
      call[option::sizes].empty() ? Extent{1024, 1024} : parse_size(call[option::sizes].front());
  const bool is_of_files = call[option::sizes].empty() && has_pixels_of_files(name);
  if (is_of_files && kind == "weak") {
    throw InputError(
        fmt::format("{} has the size of its files, and weak scaling other ones: give --size", name));
  }
  const std::string backends = call[option::backends].empty() ? "openmp" : call[option::backends].front();
  const auto registry = make_backends();
  Progress progress(ranks.is_first());
  json rows = json::array();
  for (int count = 1; count <= ranks.size();) { // 1, 2, 4 ... and all
    progress.describe(fmt::format("{} ranks", count));
    SceneOptions options{.energy = call.schedule.energy_to_be()};
    if (!is_of_files) {
      options.size = kind == "weak" ? scaled(size, std::sqrt(count)) : size;
    }
    Scene scene = load_scene(name, options);
    call.schedule.apply(scene);
    unload(scene, progress);
    const RankBackend backend(ranks, registry, backends, call.session(), {.pieces = count});
    rows.push_back(measure_on_ranks(scene, kind, backend, call[option::repeat], ranks));
    call.keep(rows, "scaling");
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
                               "message_seconds:in messages"));
  call.write(std::move(rows), "scaling");
  return success;
}

int run_bench(Call& call) {
  const Gates gates(call);
  if (call.ranks != nullptr) {
    return bench_on_ranks(call, *call.ranks);
  }
  return gates.judge(measure_scenes(call), call);
}

} // namespace

void add_bench(CLI::App& program, Call& call) {
  add_command(
      program, call, "bench", run_bench,
      "Time solutions and steps on every backend.\n"
      "Time every backend on whole solutions and compare with the thesis: Tables 5.2, 5.4, 5.6 and 5.8 at\n"
      "300, 600 and 1200 by default; volumes at 64x64x64 and 128x128x128, and scenes of image files as\n"
      "these are. Speed-ups are over scalar, one thread at -O2, in the same run; a backend whose field is\n"
      "not scalar's to the bit gets no speed-up and exit status 1. What the devices can do at most, in\n"
      "copying memory and in arithmetic, is measured in the same run.",
      {comparison_options(), option::law, Options(option::repeat, "Samples per case", 5), work, scaling,
       kernels, no_ceilings, reference_name, benchmark_json, library_options(), comparison_of_programs(),
       gate_options()},
      {"--methods excludes --method", "--kernels excludes scenes --against", "--tolerance needs --against",
       "--pairs needs --against", "--strict needs --against",
       "--against excludes --benchmark_filter --benchmark_list_tests --benchmark_repetitions "
       "--benchmark_out --benchmark-json --benchmark_format --repeat --reference"});
}

} // namespace hdmbench::commands
