#include "harness/solve/methods/elastic.hpp"

#include "backends/shared/stopwatch.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/laws.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/set_aside.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hdmbench {

namespace {

/// Conjugate gradients until what is left is within `accuracy`, pixels, at most so many steps. Returns
/// whether it is, or is rounding.
bool step_until(double accuracy, int most_steps, const Level& level, ElasticSolver& solver) {
  RemainingError error(level);
  for (int done = 0; done < most_steps && !error.is_within(accuracy); ++done) {
    const ElasticSolver::Step step = solver.conjugate_gradients();
    if (step.ended) {
      return step.at_rest;
    }
    error.add(step);
  }
  return error.is_within(accuracy);
}

} // namespace

void solve_within(double accuracy, int most_steps, const Level& level, ElasticSolver& solver) {
  solver.full_multigrid();
  step_until(accuracy, most_steps, level, solver);
}

SolutionToShare solve_to_share(double share, int most_steps, const Level& level, ElasticSolver& solver) {
  solver.full_multigrid();
  const bool is_within =
      step_until(share * root_mean_square(solver.displacement()), most_steps, level, solver);
  solver.settle(level);
  return {solver.displacement(), is_within};
}

namespace {

/// Takes the steps of the schedule's method. `largest`: component of the targets, pixels, which says nothing
/// where the scene `has_forces`; `error`: of the scene, no step added. Tells `solution` the error that is
/// left where the method knows it, and whether cycles grew.
void follow(const Schedule& schedule, double largest, bool has_forces, RemainingError error,
            ElasticSolver& solver, Progress& progress, Solution& solution) {
  const auto sites = static_cast<double>(solver.work().front().extent.sites());
  if (schedule.method == elastic_sweeps) {
    for (int done = 0; done < schedule.iterations; ++done) {
      solver.sweep();
      progress.advance(sites);
    }
    return;
  }
  const bool gradients = schedule.method == elastic_conjugate_gradients;
  solver.full_multigrid(gradients || schedule.iterations > 0);
  const int steps = schedule.iterations - (gradients ? 0 : 1); // the first cycle is full multigrid's own
  largest = std::max(largest, has_forces ? largest_component(solver.displacement()) : 0.0);
  const double rounding = solver.rounding(largest, error.contrast());
  const double least = 0.01 * largest * std::numeric_limits<float>::epsilon(); // it changes nothing
  CyclesError of_cycles(error.contrast(), error.oblong(), rounding);
  bool at_rest = false;
  for (int done = 0; done < steps && !at_rest; ++done) {
    const ElasticSolver::Step step = gradients ? solver.conjugate_gradients() : solver.cycle();
    progress.advance(sites);
    if (step.ended && !step.at_rest) {
      return;
    }
    at_rest = step.ended;
    if (!at_rest) {
      error.add(step);
      of_cycles.add(step.change);
      solution.grew = !gradients && of_cycles.grow();
      if (solution.grew || error.is_at_rest(least)) {
        break;
      }
    }
  }
  if (solution.grew || !error.mistrust().empty() || !(error.is_known() || at_rest)) {
    return;
  }
  const double left = !error.is_known()      ? 0.0
                      : gradients || at_rest ? error.estimate()
                                             : of_cycles.estimate();
  if (const double estimate = std::hypot(left, rounding); std::isfinite(estimate)) {
    solution.estimated_error = estimate;
  }
}

/// By the scene's method on the image itself. `unread`: SolveOptions::unread.
Solution solve_whole(const Scene& scene, ElasticSession& session, Progress& progress, Scene* unread) {
  ElasticSolver solver(scene.full, scene.elastic, session);
  const double largest = largest_component(scene.full.target);
  const RemainingError error(scene.full);
  double setting_aside = 0.0; // seconds
  std::optional<SetAside> aside;
  if (unread != nullptr) {
    const Stopwatch watch(setting_aside);
    aside.emplace(*unread);
  }
  Solution solution;
  follow(scene.schedule, largest, has_forces(scene.full), error, solver, progress, solution);
  solver.settle(scene.full);
  solution.levels = solver.work();
  solution.timings = solver.timings();
  solution.timings.projection += setting_aside;
  {
    const Stopwatch watch(solution.timings.readback);
    solution.displacement = solver.result();
    aside.reset();
  }
  return solution;
}

} // namespace

Solution solve_elastic(const Scene& scene, ElasticSession& session, Progress& progress,
                       const SolveOptions& options) {
  if (const std::optional<Scene> scaled = with_safe_moduli(scene)) {
    return solve_elastic(*scaled, session, progress, options);
  }
  if (has_laws(scene.full)) {
    return solve_by_laws(scene.full, scene.elastic, session, usual_law_accuracy, [&](const LawStep& step) {
      progress.describe(fmt::format("{} {}: {:.2g} px left, least volume {:.2g}", scene.name,
                                    step.extent.text(), step.error, step.smallest));
    });
  }
  Solution solution = solve_whole(scene, session, progress, options.unread);
  std::ranges::reverse(solution.levels); // the coarsest first, as other methods have them
  if (options.level_done) {
    options.level_done(solution.levels.back(), solution.displacement);
  }
  return solution;
}

} // namespace hdmbench
