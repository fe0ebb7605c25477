#include "harness/solve.hpp"

#include "harness/level_sequence.hpp"
#include "harness/stopwatch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

/// One iteration at a time, until the rule says stop. Returns the number of iterations.
int step_until_stopped(const Level& level, const Schedule& schedule, int limit, Session& session,
                       Timings& timings) {
  StopRule rule(schedule, limit);
  VectorField displacement;
  int iterations = 0;
  while (rule.may_continue(iterations)) {
    std::int64_t changed = 0;
    {
      const Stopwatch watch(timings.compute);
      for (int sweep = 0; sweep < sweeps_per_iteration(level.update); ++sweep) {
        session.step(1);
        changed += session.changed();
      }
      ++iterations;
    }
    if (rule.needs_field()) {
      const Stopwatch watch(timings.readback);
      session.read(displacement);
    }
    rule.report(changed, level, displacement);
  }
  return iterations;
}

} // namespace

std::string method_name(const Schedule& schedule) {
  const bool other_update = schedule.method == "icm" && schedule.update != Update::simultaneous;
  return other_update ? std::string(update_names[static_cast<std::size_t>(schedule.update)])
                      : schedule.method;
}

Solution solve(const Scene& scene, Session& session, Progress& progress, const SolveOptions& options) {
  LevelSequence levels(scene);
  Solution solution;
  for (const int index : levels.order()) {
    const auto [level, begin] = timed(solution.timings.projection, [&] {
      return std::pair<const Level&, VectorField>(levels.sample(index),
                                                  levels.begin(index, solution.displacement));
    });
    {
      const Stopwatch watch(solution.timings.upload);
      session.load(level);
      session.write(begin);
    }
    LevelResult result{.level = index, .extent = level.extent};
    if (scene.schedule.stop == Stop::fixed) {
      const Stopwatch watch(solution.timings.compute);
      session.step(levels.iterations(index) * sweeps_per_iteration(level.update));
      result.iterations = levels.iterations(index);
    } else {
      result.iterations =
          step_until_stopped(level, scene.schedule, levels.iterations(index), session, solution.timings);
    }
    if (options.last_changed) {
      result.changed = session.changed();
    }
    {
      const Stopwatch watch(solution.timings.readback);
      session.read(solution.displacement);
    }
    solution.levels.push_back(result);
    if (options.level_done) {
      options.level_done(result, solution.displacement);
    }
    progress.advance(static_cast<double>(level.extent.sites()) * levels.iterations(index));
  }
  return solution;
}

std::int64_t total_iterations(std::span<const LevelResult> levels) {
  std::int64_t sum = 0;
  for (const LevelResult& level : levels) {
    sum += level.iterations;
  }
  return sum;
}

double total_site_updates(std::span<const LevelResult> levels) {
  double sum = 0.0;
  for (const LevelResult& level : levels) {
    sum += static_cast<double>(level.extent.sites()) * (level.iterations + level.residuals);
  }
  return sum;
}

double site_updates(const Scene& scene, std::optional<int> iteration_limit) {
  const LevelSequence levels(scene);
  double sum = 0.0;
  for (const int index : levels.order()) {
    sum += static_cast<double>(levels.extent(index).sites()) *
           std::min(levels.iterations(index), iteration_limit.value_or(levels.iterations(index)));
  }
  return sum;
}

} // namespace hdmbench
