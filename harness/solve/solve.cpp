#include "harness/solve/solve.hpp"

#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/stopwatch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hdmbench {

namespace {

/// A session, the schedule that it follows and the seconds it takes.
class LevelSolver {
public:
  LevelSolver(Session& session, const Schedule& schedule, Timings& timings)
      : session_(session), schedule_(schedule), timings_(timings) {}

  /// From `begin`, at most `limit` iterations. Returns the number of iterations.
  int solve(const Level& level, const VectorField& begin, int limit, VectorField& displacement) {
    {
      const Stopwatch watch(timings_.upload);
      session_.load(level);
      session_.write(begin);
    }
    int iterations = limit;
    if (schedule_.stop == Stop::fixed) {
      const Stopwatch watch(timings_.compute);
      session_.step(limit * sweeps_per_iteration(level));
    } else {
      iterations = step_until_stopped(level, limit);
    }
    const Stopwatch watch(timings_.readback);
    session_.read(displacement);
    return iterations;
  }

private:
  /// One iteration at a time, until the rule says stop.
  int step_until_stopped(const Level& level, int limit) {
    StopRule rule(schedule_, limit);
    VectorField displacement;
    int iterations = 0;
    while (rule.may_continue(iterations)) {
      std::int64_t changed = 0;
      {
        const Stopwatch watch(timings_.compute);
        for (int sweep = 0; sweep < sweeps_per_iteration(level); ++sweep) {
          session_.step(1);
          changed += session_.changed();
        }
        ++iterations;
      }
      if (rule.needs_field()) {
        const Stopwatch watch(timings_.readback);
        session_.read(displacement);
      }
      rule.report(changed, level, displacement);
    }
    return iterations;
  }

  Session& session_;
  const Schedule& schedule_;
  Timings& timings_;
};

/// All levels in one call of the session.
Solution solve_in_one_piece(const LevelSequence& levels, const Pyramid& pyramid, Session& session,
                            Progress& progress) {
  Solution solution;
  {
    const Stopwatch watch(solution.timings.upload);
    session.load(pyramid);
  }
  {
    const Stopwatch watch(solution.timings.compute);
    const double sweeps = sweeps_per_iteration(*pyramid.full);
    session.solve([&](double site_updates) { progress.advance(site_updates / sweeps); });
  }
  const Stopwatch watch(solution.timings.readback);
  session.read(solution.displacement);
  for (const int level : levels.order()) {
    solution.levels.push_back(
        {.level = level, .extent = levels.extent(level), .iterations = levels.iterations(level)});
  }
  return solution;
}

} // namespace

std::string method_name(const Scene& scene) {
  const std::string& method = scene.schedule.method;
  const Update update = scene.full.update;
  const bool other_update = method == "icm" && update != Update::simultaneous;
  return other_update ? std::string(update_names[static_cast<std::size_t>(update)]) : method;
}

Solution solve(const Scene& scene, Session& session, Progress& progress, const SolveOptions& options) {
  LevelSequence levels(scene);
  if (const auto pyramid = levels.pyramid(); pyramid && !options.level_done && !options.last_changed) {
    return solve_in_one_piece(levels, *pyramid, session, progress);
  }
  Solution solution;
  LevelSolver solver(session, scene.schedule, solution.timings);
  for (const int index : levels.order()) {
    const auto [level, begin] = timed(solution.timings.projection, [&] {
      return std::pair<const Level&, VectorField>(levels.sample(index),
                                                  levels.begin(index, solution.displacement));
    });
    const int limit = levels.iterations(index);
    LevelResult result{.level = index, .extent = level.extent};
    result.iterations = solver.solve(level, begin, limit, solution.displacement);
    result.repeated = timed(solution.timings.projection, [&, &from = begin, &of = level] {
      return has_diverged(of, from, solution.displacement);
    });
    if (result.repeated) {
      result.iterations +=
          solver.solve(levels.sample_without_acceleration(index), begin, limit, solution.displacement);
    }
    if (options.last_changed) {
      result.changed = session.changed();
    }
    solution.levels.push_back(result);
    if (options.level_done) {
      options.level_done(result, solution.displacement);
    }
    progress.advance(static_cast<double>(level.extent.sites()) * limit);
  }
  return solution;
}

double largest_component(const VectorField& field) {
  float largest = 0.0F;
  for (const std::vector<float>& component : field.planes) {
    for (const float value : component) {
      largest =
          std::isnan(value) ? std::numeric_limits<float>::infinity() : std::max(largest, std::abs(value));
    }
  }
  return static_cast<double>(largest);
}

std::string why_absurd(const Scene& scene, const VectorField& field) {
  const double found = largest_component(field);
  if (!std::isfinite(found)) {
    return "the field has components that are infinite or not a number";
  }
  const Level& full = scene.full;
  double given = scene.start ? largest_component(*scene.start) : 0.0; // what drives a field, pixels
  for (std::size_t i = 0; i < full.extent.sites(); ++i) {
    given = std::max({given,
                      full.confidence[0][i] > 0.0F ? std::abs(static_cast<double>(full.target[0][i])) : 0.0,
                      full.confidence[1][i] > 0.0F ? std::abs(static_cast<double>(full.target[1][i])) : 0.0});
  }
  const double sides = static_cast<double>(full.extent.width) + static_cast<double>(full.extent.height);
  const bool is_absurd = found > 100.0 * sides * std::max(given, 1.0);
  return is_absurd
             ? fmt::format("the field reaches {:.3g} px, where conditions and start give {:.3g} px at most",
                           found, given)
             : "";
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
  if (scene.energy->is_of_cells()) {
    return static_cast<double>(scene.extent().sites()) * scene.schedule.iterations;
  }
  const LevelSequence levels(scene);
  double sum = 0.0;
  for (const int index : levels.order()) {
    sum += static_cast<double>(levels.extent(index).sites()) *
           std::min(levels.iterations(index), iteration_limit.value_or(levels.iterations(index)));
  }
  return sum;
}

} // namespace hdmbench
