#include "harness/solve/planner/elastic_planner.hpp"

#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hdmbench {

namespace {

/// Thin stiff layers take most: 37 at a contrast of 1000 to 1e-4 px.
constexpr int most_steps = 100;

} // namespace

Plan solve_elastic_as_needed(const Scene& scene, const Request& request, const Backend& backend,
                             const SessionOptions& options, Progress& progress) {
  if (const std::string why = why_not_solved(scene, backend); !why.empty()) {
    throw InputError(fmt::format("{} {}; use --backend scalar", backend.name(), why));
  }
  Plan plan;
  const Extent extents[] = {scene.extent()};
  plan.survey = survey(scene, extents);
  const auto session = backend.open_elastic(options);
  const Clock clock;
  ElasticSolver solver(scene.full, scene.poisson, *session);
  const double unknown = std::numeric_limits<double>::infinity();
  const auto note = [&](std::string action, std::string reason, double moved, double error) {
    plan.steps.push_back({.extent = scene.extent(),
                          .action = std::move(action),
                          .reason = std::move(reason),
                          .moved = moved,
                          .expected_error = error,
                          .seconds = clock.seconds()});
    progress.describe(fmt::format("{}: {}", scene.name, plan.steps.back().action));
  };
  note("levels", "moments of the moduli and cut cells on all levels", 0.0, unknown);
  const double set_up = clock.seconds();
  solver.full_multigrid();
  note("multigrid", "from the coarsest level up, a W cycle on each", 0.0, unknown);

  RemainingError error;
  double last = clock.seconds() - set_up; // a step costs no more than full multigrid
  for (int i = 0; i < most_steps; ++i) {
    const double before = clock.seconds();
    const bool accurate = request.accuracy && error.is_within(*request.accuracy);
    if (accurate || (request.seconds && before + last > *request.seconds)) {
      break;
    }
    const ElasticSolver::Step step = solver.conjugate_gradients();
    if (step.ended) {
      note("end", "what is left is rounding", 0.0, unknown);
      break;
    }
    const double moved = std::sqrt(2.0) * step.change; // of sites, from that of components
    error.add(moved);
    last = clock.seconds() - before;
    note("gradients",
         i == 0             ? std::string("says how far full multigrid was from the end")
         : request.accuracy ? fmt::format("{:.3g} px are asked for", *request.accuracy)
                            : std::string("there is time left"),
         moved, error.estimate());
  }
  Solution& solution = plan.solution;
  solution.displacement = solver.displacement();
  solution.levels = solver.work();
  std::ranges::reverse(solution.levels);
  solution.timings = solver.timings();
  const double largest =
      std::max(std::abs(plan.survey.smallest_target), std::abs(plan.survey.largest_target));
  if (error.is_known()) {
    // No field was seen closer to the truth than this, whatever the moduli.
    solution.estimated_error = std::hypot(error.estimate(), largest * std::numeric_limits<float>::epsilon());
  }
  conclude(plan, request, clock.seconds(), "finite elements");
  return plan;
}

} // namespace hdmbench
