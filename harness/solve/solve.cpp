#include "harness/solve/solve.hpp"

#include "backends/shared/stopwatch.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "kernels/data/elastic/springs.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace hdmbench {

namespace {

/// Follows the schedule from `begin`, at most `limit` iterations. Returns the number of iterations.
int solve_level(const Level& level, const VectorField& begin, int limit, const Schedule& schedule,
                Session& session, VectorField& displacement, Timings& timings) {
  timed(timings.upload, [&] {
    session.load(level);
    session.write(begin);
  });
  const int sweeps = sweeps_per_iteration(level);
  int iterations = schedule.stop == Stop::fixed ? limit : 0;
  timed(timings.compute, [&] { session.step(iterations * sweeps); });
  for (StopRule rule(schedule, limit); rule.may_continue(iterations); ++iterations) {
    std::int64_t changed = 0;
    timed(timings.compute, [&] {
      for (int sweep = 0; sweep < sweeps; ++sweep) {
        session.step(1);
        changed += session.changed();
      }
    });
    if (rule.needs_field()) {
      timed(timings.readback, [&] { session.read(displacement); });
    }
    rule.report(changed, level, displacement);
  }
  timed(timings.readback, [&] { session.read(displacement); });
  return iterations;
}

/// All levels in one call of the session.
Solution solve_in_one_piece(const LevelSequence& levels, const Pyramid& pyramid, Session& session,
                            Progress& progress) {
  Solution solution;
  const double sweeps = sweeps_per_iteration(*pyramid.full);
  timed(solution.timings.upload, [&] { session.load(pyramid); });
  timed(solution.timings.compute,
        [&] { session.solve([&](double site_updates) { progress.advance(site_updates / sweeps); }); });
  timed(solution.timings.readback, [&] { session.read(solution.displacement); });
  for (const int level : levels.order()) {
    solution.levels.push_back(
        {.level = level, .extent = levels.extent(level), .iterations = levels.iterations(level)});
  }
  return solution;
}

} // namespace

std::string method_name(const Scene& scene) {
  if (has_laws(scene.full)) {
    return "non-linear conjugate gradients";
  }
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
  const auto solve_from = [&](const VectorField& begin, const Level& level, int limit) {
    return solve_level(level, begin, limit, scene.schedule, session, solution.displacement, solution.timings);
  };
  for (const int index : levels.order()) {
    const auto [level, begin] = timed(solution.timings.projection, [&] {
      return std::pair<const Level&, VectorField>(levels.sample(index),
                                                  levels.begin(index, solution.displacement));
    });
    const int limit = levels.iterations(index);
    LevelResult result{.level = index, .extent = level.extent};
    result.iterations = solve_from(begin, level, limit);
    result.repeated = timed(solution.timings.projection, [&, &from = begin, &of = level] {
      return has_diverged(of, from, solution.displacement);
    });
    if (result.repeated) {
      result.iterations += solve_from(begin, levels.sample_without_acceleration(index), limit);
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

double largest_component(const VectorField& field, const ScalarField& tissue) {
  float largest = 0.0F;
  for (const std::vector<float>& component : field.planes) {
    for (std::size_t site = 0; site < component.size(); ++site) {
      if (tissue.values.empty() || tissue.values[site] > 0.0F) {
        largest = std::isnan(component[site]) ? std::numeric_limits<float>::infinity()
                                              : std::max(largest, std::abs(component[site]));
      }
    }
  }
  return static_cast<double>(largest);
}

double dot(const VectorField& first, const VectorField& second) {
  const Extent extent = first.extent;
  std::vector<double> of_rows(static_cast<std::size_t>(extent.rows()));
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    const std::size_t begin = extent.index(0, row);
    std::array<double, 8> sums{}; // of every eighth product: whatever vectors a processor has
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      const float* const one = first[axis].data() + begin;
      const float* const other = second[axis].data() + begin;
      const auto width = static_cast<std::size_t>(extent.width);
      for (std::size_t at = 0; at + sums.size() <= width; at += sums.size()) {
#pragma omp simd
        for (std::size_t lane = 0; lane < sums.size(); ++lane) {
          sums[lane] += static_cast<double>(one[at + lane]) * static_cast<double>(other[at + lane]);
        }
      }
      for (std::size_t at = width / sums.size() * sums.size(); at < width; ++at) {
        sums[at % sums.size()] += static_cast<double>(one[at]) * static_cast<double>(other[at]);
      }
    }
    of_rows[static_cast<std::size_t>(row)] = std::accumulate(sums.begin(), sums.end(), 0.0);
  }
  return std::accumulate(of_rows.begin(), of_rows.end(), 0.0);
}

double root_mean_square(const VectorField& field) {
  return std::sqrt(dot(field, field) / static_cast<double>(field.extent.sites()));
}

std::string why_absurd(const Scene& scene, const Solution& solution) {
  const double found = largest_component(solution.displacement);
  if (!std::isfinite(found)) {
    return "the field has components that are infinite or not a number";
  }
  if (!solution.failure.empty()) {
    return solution.failure;
  }
  if (solution.grew) {
    return "each cycle moved the field farther than the one before";
  }
  const Level& full = scene.full;
  double given = scene.start ? largest_component(*scene.start) : 0.0; // what drives a field, pixels
  for (std::size_t axis = 0; axis < full.extent.axes(); ++axis) {
    for (std::size_t i = 0; i < full.extent.sites(); ++i) {
      if (full.confidence[axis][i] > 0.0F || has_springs_by_direction(full)) {
        given = std::max(given, std::abs(static_cast<double>(full.target[axis][i])));
      }
    }
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
