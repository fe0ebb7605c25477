#include "harness/cli/verify_windows.hpp"

#include "harness/check/verify_row.hpp"
#include "harness/cli/commands.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/grouped.hpp"
#include "harness/report/table.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <map>
#include <span>
#include <utility>

namespace hdmbench::commands {

namespace {

/// What a scene needs to be printed after it is gone.
struct Problem {
  std::string scene;
  Extent extent;
  std::string method;
  std::string repeat; ///< command line
};

/// Whether a session that cannot read a scene in place has room to copy it, its levels and its fields.
bool has_room_for_a_pyramid(Extent extent) {
  constexpr double needed = 80.0; // bytes a site, beside the scene
  const double free =
      static_cast<double>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  return needed * static_cast<double>(extent.sites()) < free;
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

void print_levels(const WindowedComparison& comparison) {
  Table table(
      {"level", "size", "sweeps", "<compared", "sites compared", "of all", "differing", "<count of changes"});
  for (const WindowedLevel& level : comparison.levels) {
    const double share =
        static_cast<double>(level.sites_compared) / static_cast<double>(level.extent.sites());
    table.add({std::to_string(level.level), fmt::format("{} x {}", level.extent.width, level.extent.height),
               std::to_string(level.sweeps),
               fmt::format("{}{}", level.whole ? "whole" : fmt::format("{} windows", level.windows.size()),
                           level.level_by_level ? "" : ", in one piece"),
               grouped(level.sites_compared), fmt::format("{:.4g} %", 100.0 * share),
               grouped(level.sites_differing),
               level.count_differs ? "wrong"
               : level.whole       ? "right"
                                   : "-"});
  }
  fmt::print("{}", table.text());
}

void print(const Problem& problem, const WindowedComparison& comparison, const WindowOptions& options,
           bool room) {
  fmt::print("\n{}, {} x {}, {}, {}{}{}\n", problem.scene, problem.extent.width, problem.extent.height,
             problem.method, comparison.backend, comparison.device.name.empty() ? "" : " on ",
             comparison.device.name);
  if (comparison.verdict == Verdict::skipped) {
    fmt::print("  skipped: {}\n", comparison.reason);
    return;
  }
  print_levels(comparison);
  for (const WindowedLevel& level : comparison.levels) {
    if (level.first) {
      const DifferingSite& site = *level.first;
      fmt::print("  level {}, x = {}, y = {}: expected ({}, {}), found ({}, {}) px\n", level.level, site.x,
                 site.y, site.expected[0], site.expected[1], site.found[0], site.found[1]);
    }
  }
  for (const WindowedPyramid& pyramid : comparison.pyramids) {
    const auto said = [](const char* what, const std::optional<bool>& same) {
      return same ? fmt::format("; {} {}", *same ? "the same" : "ANOTHER", what) : std::string();
    };
    fmt::print("  in one piece, {}: {} sites differ in the windows of the last level{}{}\n",
               work_names.at(static_cast<std::size_t>(pyramid.work)), grouped(pyramid.sites_differing),
               said("field as level by level (hash of all sites)", pyramid.same_field),
               said("count", pyramid.same_count));
  }
  if (!room) {
    fmt::print("  not solved in one piece: too little memory is free for a second copy of all levels\n"
               "  (--last-level one-piece tries it all the same)\n");
  }
  const double peak = peak_memory();
  fmt::print("  seed {}; at most {:.2f} GiB of memory so far, {:.0f} bytes a site; {}\n", options.plan.seed,
             peak / 0x1p30, peak / static_cast<double>(problem.extent.sites()), name_of(comparison.verdict));
  if (comparison.verdict == Verdict::disagree) {
    fmt::print("    repeat: {}\n", problem.repeat);
  }
}

} // namespace

void WindowArguments::add_to(CLI::App& command) {
  const auto* const group = "Images too large for scalar";
  command
      .add_option("--windows", windows,
                  "Compare large levels in so many windows only, once, after all their sweeps: the corners, "
                  "an interface, the rest by --seed")
      ->check(CLI::Range(1, 1'000'000))
      ->group(group);
  command
      .add_option("--whole", whole_side,
                  "With --windows: compare levels of up to so many sites squared as a whole")
      ->check(CLI::Range(0, 32768))
      ->capture_default_str()
      ->group(group);
  const std::map<std::string, LastLevel> ways{{"both", LastLevel::both},
                                              {"levels", LastLevel::levels_only},
                                              {"one-piece", LastLevel::in_one_piece_only}};
  command
      .add_option(
          "--last-level", last_level,
          "With --windows: compute the full resolution level by level (levels), by the call that makes all "
          "levels at once (one-piece) or both (none: both, or levels where memory is short)")
      ->transform(CLI::CheckedTransformer(ways))
      ->group(group);
}

int run_verify_windows(CommonArguments arguments, const WindowArguments& windows, const std::string& line) {
  if (!arguments.methods.empty()) {
    throw InputError("--windows goes with one --method, not with --methods");
  }
  require_results_writable(arguments.json);
  const auto registry = make_backends();
  const std::vector<const Backend*> backends = arguments.choose(registry);
  WindowOptions options{.session = arguments.session};
  options.plan.windows = windows.windows;
  options.plan.seed = static_cast<std::uint64_t>(std::exchange(arguments.schedule.seed, {}).value_or(0));
  options.whole = static_cast<std::size_t>(windows.whole_side) * static_cast<std::size_t>(windows.whole_side);
  if (arguments.quick) {
    options.iteration_limit = quick_iterations;
  }
  SceneArguments one;
  one.schedule = arguments.schedule;
  if (arguments.scenes.empty()) {
    arguments.scenes.emplace_back("square");
  }
  if (arguments.sizes.empty()) {
    arguments.sizes.emplace_back(); // each scene's own
  }

  nlohmann::json rows = nlohmann::json::array();
  bool agree = true;
  for (const std::string& name : arguments.scenes) {
    for (const std::string& size : arguments.sizes) {
      for (const Backend* const backend : std::span(backends).subspan(1)) {
        one.scene = name;
        one.size = size;
        Progress progress;
        progress.describe(fmt::format("prepare {}{}{}", name, size.empty() ? "" : ", ", size));
        Scene scene = one.load();
        const bool room = windows.last_level || has_room_for_a_pyramid(scene.extent());
        options.last_level = windows.last_level.value_or(room ? LastLevel::both : LastLevel::levels_only);
        const Problem problem{.scene = scene.name,
                              .extent = scene.extent(),
                              .method = method_name(scene),
                              .repeat = fmt::format("{} --windows {} --whole {} --seed {}",
                                                    arguments.repeat("verify", scene, backend->name()),
                                                    windows.windows, windows.whole_side, options.plan.seed)};
        progress.set_total(windowed_site_updates(scene, options));
        const WindowedComparison comparison =
            verify_windows(std::move(scene), *backends.front(), *backend, options, progress);
        progress.clear();
        print(problem, comparison, options, room);
        std::fflush(stdout);
        agree = agree && comparison.verdict != Verdict::disagree;
        rows.push_back(to_json_row(verify_row(problem.scene, problem.extent, problem.method, comparison)));
      }
    }
  }
  fmt::print(
      "\nWhat lies outside the windows was not compared; each level began with the backend's own field.\n");
  write_results(arguments.json, "verify", run_context(line, arguments.quick), std::move(rows));
  return agree ? success : disagreement;
}

} // namespace hdmbench::commands
