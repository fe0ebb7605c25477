#include "harness/judge/tradeoff.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/judged_text.hpp"
#include "harness/scene/method.hpp"

#include <cstdio>
#include <utility>

namespace hdmbench::commands {

namespace {

struct Arguments : CommonArguments {
  int repeats = 3;
  std::vector<std::string> at{"0.35px", "0.01px"};
};

/// `equal`: as compare_at has it.
void print_equal_accuracy(const json& equal) {
  const auto number = [](const json& row, const char* key) { return row[key].get<double>(); };
  const auto text = [](const json& row, const char* key) { return row[key].get<std::string>(); };
  const double target = number(equal, "target");
  const json& ours = equal["ours"];
  if (ours.is_null()) {
    if (!equal["nearest"].is_null()) {
      fmt::print("  At {:.3g} px to FEM nu 0: no method is that near; the nearest is {:.3g} px away.\n",
                 target, number(equal, "nearest"));
    }
    return;
  }
  fmt::print("  At {:.3g} px to FEM nu 0: {}, {} on {} is the fastest, {:.3g} s;\n", target,
             text(ours, "method"), text(ours, "effort"), text(ours, "backend"),
             number(ours, "seconds_median"));
  for (const auto& [key, title] : {std::pair("direct", "direct FEM"),
                                   {"iterative", "FEM by conjugate gradients"},
                                   {"multigrid", "FEM by multigrid of others"},
                                   {"coarse", "FEM on a coarse mesh"}}) {
    if (const json& rival = equal[key]; !rival.is_null()) {
      fmt::print("    {} ({}, {:.3g} s) takes {:.3g} times as long.\n", title, text(rival, "effort"),
                 number(rival, "seconds_median"), number(rival, "ratio"));
    } else {
      fmt::print("    {} was not measured, or is nowhere that near.\n", title);
    }
  }
}

/// The line that repeats a point: `run` solves by methods, this command by rivals.
std::string repeat(const Arguments& arguments, const Scene& scene, const Judged& row) {
  const std::string where =
      fmt::format("{} --size {}x{}", shell_word(scene.source), scene.extent().width, scene.extent().height);
  if (row.is_rival) {
    return fmt::format("hdmbench tradeoff {} --methods {}{}", where, row.method, arguments.schedule.text());
  }
  const std::string how = row.asked ? fmt::format("--energy elastic --accuracy {}px --explain", *row.asked)
                                    : fmt::format("--method {} --iterations {}", row.method, *row.told);
  return fmt::format("hdmbench run {} --backend {} {}{}{}", where, row.backend, how,
                     row.backend == "scalar" ? "" : arguments.session_words(), arguments.schedule.text());
}

int run_tradeoff(Arguments& arguments, Call& call) {
  std::vector<double> targets;
  std::ranges::transform(arguments.at, std::back_inserter(targets),
                         [](const std::string& text) { return parse_pixels(text); });
  // Among them rivals and requests, which load_scenes does not know.
  std::vector<std::string> methods = std::exchange(arguments.methods, {});
  if (methods == std::vector<std::string>{"all"}) {
    methods.clear();
  }
  const auto registry = make_backends();
  const std::vector<const Backend*> backends = arguments.choose(registry);
  Progress progress;
  json results = json::array();
  bool verified = true;
  fmt::print(
      "Seconds are medians of up to {} samples of a whole solution without set-up. RMSD to finite elements "
      "and to the\nfixed point over all sites, in pixels. Of the points: the front, and what was asked "
      "for.\n",
      arguments.quick ? 1 : arguments.repeats);
  std::vector<std::string> by_default{"square", "circular", "circular-radial", "brain"};
  by_default.resize(arguments.quick ? 1 : by_default.size());
  for (const Scene& scene : arguments.load_scenes(by_default)) {
    const TradeoffOptions options{.session = arguments.session,
                                  .repeats = arguments.repeats,
                                  .methods = methods,
                                  .quick = arguments.quick};
    const std::vector<Judged> rows = measure_tradeoff(scene, backends, options, progress);
    progress.clear();
    json shown = json::array();
    for (const Judged& row : rows) {
      results.push_back(to_json(scene, row));
      results.back()["kind"] = "point";
      results.back()["command"] = repeat(arguments, scene, row);
      verified = verified && row.status != JudgedStatus::unverified;
      if (!row.seconds.empty() && (row.is_on_front || row.asked)) {
        shown.push_back(results.back());
      }
    }
    std::ranges::sort(shown.get_ref<json::array_t&>(), {},
                      [](const json& row) { return row["seconds_median"].get<double>(); });
    fmt::print("\n{}, {} x {}: {} points\n{}", scene.name, scene.extent().width, scene.extent().height,
               rows.size(), judged_table(shown));
    for (const double target : targets) {
      print_equal_accuracy(results.emplace_back(compare_at(scene, rows, target)));
    }
    fmt::print("{}", failures_text(rows));
    std::fflush(stdout); // into a pipe too: the next scene may take long
  }
  call.write(std::move(results), arguments.quick);
  return verified ? success : disagreement;
}

} // namespace

void add_tradeoff(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "tradeoff",
      "Speed against accuracy: every method at several efforts, and its rivals (finite elements direct, by\n"
      "conjugate gradients and on a coarse mesh, interpolation), timed and measured against the truths.\n"
      "Prints the Pareto front per scene; the report draws the chart. Exit status 1 where a field is not\n"
      "scalar's to the bit.",
      run_tradeoff);
  own.schedule.takes_energy = true;
  own.add_to(command, call);
  remove_options(command, {"--method", "--iterations", "--update", "--steps"});
  add_option(command, "--at", own.at, "Accuracies at which the fastest are compared: RMSD to FEM with nu 0")
      ->delimiter(',');
  add_option(command, "--repeat", own.repeats, "Samples per point, fewer where they take long")
      ->excludes("--quick")
      ->check(CLI::Range(1, 1'000'000));
}

} // namespace hdmbench::commands
