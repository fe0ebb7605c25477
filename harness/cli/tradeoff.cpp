#include "harness/judge/tradeoff.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/judged_text.hpp"
#include "harness/cli/plan_text.hpp"
#include "harness/measure/median.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/method.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace hdmbench::commands {

namespace {

struct Arguments : CommonArguments {
  int repeats = 3;
  std::vector<std::string> at{"0.35px", "0.01px"};
  bool all = false;
};

std::vector<std::string> scenes_by_default(bool quick) {
  return quick ? std::vector<std::string>{"square"}
               : std::vector<std::string>{"square", "circular", "circular-radial", "brain"};
}

std::string seconds_text(double seconds) {
  return fmt::format("{:.3g}", seconds);
}

void print_points(const std::vector<Judged>& rows, bool all) {
  std::vector<const Judged*> shown;
  for (const Judged& row : rows) {
    if (!row.seconds.empty() && (all || row.is_on_front)) {
      shown.push_back(&row);
    }
  }
  if (!all) {
    std::ranges::sort(shown, {}, [](const Judged* row) { return median(row->seconds); });
  }
  fmt::print("{}", table_text(shown));
}

void print_requests(const std::vector<Judged>& rows) {
  Table table({"asked px", "<from", "estimated", "reached", "fine sweeps", "seconds"});
  bool any = false;
  for (const Judged& point : rows) {
    if (point.asked && !point.seconds.empty()) {
      any = true;
      table.add({fmt::format("{:.3g}", *point.asked),
                 point.poisson_used ? fmt::format("FEM nu {:.2g}", *point.poisson_used)
                                    : std::string("fixed point"),
                 point.estimated ? pixels_text(*point.estimated) : "", pixels_text(reached(point)),
                 fmt::format("{:.3g}", *point.fine_sweep_equivalents), seconds_text(median(point.seconds))});
    }
  }
  if (any) {
    fmt::print("\n  run --accuracy: RMSD as asked for, as estimated and as it is\n\n{}", table.text());
  }
}

void print_equal_accuracy(const EqualAccuracy& equal) {
  if (equal.ours == nullptr) {
    if (std::isfinite(equal.nearest)) {
      fmt::print("  At {:.3g} px to FEM nu 0: no method is that near; the nearest is {} px away.\n",
                 equal.target, pixels_text(equal.nearest));
    }
    return;
  }
  fmt::print("  At {:.3g} px to FEM nu 0: {}, {} on {} is the fastest, {} s;\n", equal.target,
             equal.ours->method, equal.ours->effort, equal.ours->backend,
             seconds_text(median(equal.ours->seconds)));
  for (const EqualAccuracy::Rival& rival : equal.rivals) {
    if (rival.row != nullptr) {
      fmt::print("    {} ({}, {} s) takes {:.3g} times as long.\n", rival.title, rival.row->effort,
                 seconds_text(median(rival.row->seconds)), rival.ratio);
    } else {
      fmt::print("    {} was not measured, or is nowhere that near.\n", rival.title);
    }
  }
}

/// The line that repeats a point: `run` solves by methods, this command by rivals.
std::string repeat(const Arguments& arguments, const Scene& scene, const Judged& row) {
  const std::string where =
      fmt::format("{} --size {}x{}", shell_word(scene.source), scene.extent().width, scene.extent().height);
  if (row.is_rival) {
    return fmt::format("hdmbench tradeoff {} --methods {} --all{}", where, row.method,
                       arguments.schedule.text());
  }
  std::string line = fmt::format("hdmbench run {} --backend {}", where, row.backend);
  if (row.asked) {
    line += fmt::format(" --energy elastic --accuracy {}px --explain", *row.asked);
  } else {
    line += fmt::format(" --method {} --iterations {}", row.method, row.told->iterations);
    line += row.told->stride > 1 ? fmt::format(" --stride {}", row.told->stride) : "";
  }
  if (!arguments.session.device.empty() && row.backend != "scalar") {
    line += " --device " + shell_word(arguments.session.device);
  }
  if (arguments.session.threads != 0) {
    line += fmt::format(" --threads {}", arguments.session.threads);
  }
  return line + arguments.schedule.text();
}

int run_tradeoff(Arguments& arguments, const Command& command, const std::string& line) {
  refuse_idle(command,
              {{.here = true,
                .options = {"--method", "--iterations", "--update", "--steps"},
                .why = "tradeoff runs the methods at efforts of its own; choose with --methods"},
               {.here = arguments.quick, .options = {"--repeat"}, .why = "--quick takes one sample"}});
  std::vector<double> targets;
  std::ranges::transform(arguments.at, std::back_inserter(targets),
                         [](const std::string& text) { return parse_pixels(text); });
  require_results_writable(arguments.json);
  // Among them rivals and requests, which load_scenes does not know.
  std::vector<std::string> methods = std::exchange(arguments.methods, {});
  if (methods == std::vector<std::string>{"all"}) {
    methods.clear();
  }
  const auto registry = make_backends();
  const std::vector<const Backend*> backends = arguments.choose(registry);
  Progress progress;
  nlohmann::json results = nlohmann::json::array();
  bool verified = true;
  fmt::print(
      "Seconds are medians of up to {} samples of a whole solution without set-up. RMSD to finite elements "
      "and to the\nfixed point over all sites, in pixels.\n",
      arguments.quick ? 1 : arguments.repeats);
  for (const Scene& scene : arguments.load_scenes(scenes_by_default(arguments.quick))) {
    const TradeoffOptions options{.session = arguments.session,
                                  .repeats = arguments.repeats,
                                  .methods = methods,
                                  .quick = arguments.quick};
    const std::vector<Judged> rows = measure_tradeoff(scene, backends, options, progress);
    progress.clear();
    const auto failures =
        std::ranges::count_if(rows, [](const Judged& row) { return row.status != JudgedStatus::ok; });
    fmt::print("\n{}, {} x {}: {} points, {} of them without a result{}\n", scene.name, scene.extent().width,
               scene.extent().height, rows.size(), failures, arguments.all ? "" : " (--all lists them)");
    print_points(rows, arguments.all);
    for (const double target : targets) {
      print_equal_accuracy(compare_at(rows, target));
    }
    print_requests(rows);
    fmt::print("{}", failures_text(rows));
    std::fflush(stdout); // into a pipe too: the next scene may take long
    for (const Judged& row : rows) {
      results.push_back(to_json(scene, row));
      results.back()["kind"] = "point";
      results.back()["command"] = repeat(arguments, scene, row);
      verified = verified && row.status != JudgedStatus::unverified;
    }
    for (const double target : targets) {
      results.push_back(to_json(scene, compare_at(rows, target)));
    }
  }
  write_results(arguments.json, "tradeoff", run_context(line, arguments.quick), std::move(results));
  return verified ? success : disagreement;
}

} // namespace

void add_tradeoff(const Command& program, const std::string& arguments, int& status) {
  const Command command = program.add_subcommand(
      "tradeoff",
      "Speed against accuracy: every method at several efforts, and its rivals (finite elements direct, by\n"
      "conjugate gradients and on a coarse mesh, interpolation), timed and measured against the truths.\n"
      "Prints the Pareto front per scene; the report draws the chart. Exit status 1 where a field is not\n"
      "scalar's to the bit.");
  const auto own = std::make_shared<Arguments>();
  own->schedule.takes_elastic = true;
  own->add_to(command);
  leave_out_of_help(command, {"--method", "--iterations", "--update", "--steps"});
  command.add_option("--at", own->at, "Accuracies at which the fastest are compared: RMSD to FEM with nu 0")
      .delimiter(',')
      .capture_default_str();
  command.add_option("--repeat", own->repeats, "Samples per point, fewer where they take long")
      .range(1, 1'000'000)
      .capture_default_str();
  command.add_flag("--all", own->all, "Print all points, not the front only");
  command.callback([own, command, arguments, &status] { status = run_tradeoff(*own, command, arguments); });
}

} // namespace hdmbench::commands
