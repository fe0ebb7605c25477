#include "harness/solve/planner.hpp"

#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "harness/solve/methods/robust_observations.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

namespace hdmbench {

namespace {

/// Thin stiff layers take most: 37 at a contrast of 1000 to 1e-4 px.
constexpr int most_steps = 100;

void require_positive(const std::optional<double>& value, const char* what) {
  if (value && !(*value > 0.0 && std::isfinite(*value))) {
    throw InputError(fmt::format("{} is {}, it must be above 0", what, *value));
  }
}

} // namespace

void conclude(Plan& plan, const Scene& scene, const Request& request, double seconds,
              std::string_view mistrust) {
  std::optional<double>& error = plan.solution.estimated_error;
  const std::string absurd = why_absurd(scene, plan.solution.displacement);
  if (!absurd.empty()) {
    error.reset();
    mistrust = absurd;
  }
  const bool accurate = !request.accuracy || (error && mistrust.empty() && *error <= *request.accuracy);
  const bool in_time = !request.seconds || seconds <= *request.seconds;
  plan.met = accurate && in_time && absurd.empty();
  plan.outcome = fmt::format(
      "{}{}{} in {:.3g} ms: {}{}",
      request.accuracy ? fmt::format("asked {:.3g} px from finite elements, ", *request.accuracy) : "",
      request.seconds ? fmt::format("asked {:.3g} ms, ", 1e3 * *request.seconds) : "",
      error ? fmt::format("estimated {:.2g} px{}", *error, request.accuracy ? "" : " from finite elements")
            : "no estimate",
      1e3 * seconds, plan.met ? "met" : "NOT met", mistrust.empty() ? "" : fmt::format(" ({})", mistrust));
}

double fine_sweep_equivalents(const Plan& plan) {
  return total_site_updates(plan.solution.levels) /
         static_cast<double>(plan.solution.displacement.extent.sites());
}

Plan solve_as_needed(const Scene& scene, const Request& request, const Backend& backend,
                     const SessionOptions& options, Progress& progress) {
  require_positive(request.accuracy, "the accuracy asked for (px)");
  require_positive(request.seconds, "the time asked for (s)");
  if (scene.energy->near != ReferenceSolution::finite_elements) {
    throw InputError(
        "an accuracy is a distance from finite elements, which the elastic energy alone comes near");
  }
  if (const std::string why = why_not_solved(scene, backend); !why.empty()) {
    throw InputError(fmt::format("{} {}; use --backend scalar", backend.name(), why));
  }
  const auto session = backend.open_elastic(options);
  const Clock clock;
  Plan plan;
  std::string mistrust; // why the estimate cannot be believed; empty: it can
  const auto note = [&](std::string action, std::string reason, double moved, double error) {
    progress.describe(fmt::format("{}: {}", scene.name, action));
    plan.steps.push_back({.action = std::move(action),
                          .reason = std::move(reason),
                          .moved = moved,
                          .expected_error = error,
                          .seconds = clock.seconds()});
  };
  constexpr double unknown = std::numeric_limits<double>::infinity();
  // Full multigrid, then conjugate gradients until the steps say that it is enough.
  const TakeSteps take = [&](ElasticSolver& solver, const RobustObservations* robust) {
    if (robust != nullptr) {
      note("observations",
           fmt::format("weighed anew {} times: those far away are forgiven; then the levels", robust->rounds),
           robust->moved, unknown);
    } else {
      note("levels", "moments of the moduli and cut cells on all levels", 0.0, unknown);
    }
    const double set_up = clock.seconds();
    solver.full_multigrid();
    note("multigrid", "from the coarsest level up, a W cycle on each", 0.0, unknown);
    const double contrast = contrast_of(scene.full.modulus);
    RemainingError error(contrast);
    double last = clock.seconds() - set_up; // a step costs no more than full multigrid
    bool at_rest = false;
    for (int i = 0;; ++i) {
      const double before = clock.seconds();
      const bool accurate = request.accuracy && error.is_within(*request.accuracy);
      if (accurate || (request.seconds && before + last > *request.seconds)) {
        break;
      }
      if (i == most_steps) {
        mistrust = fmt::format("{} steps of conjugate gradients did not come to an end", most_steps);
        break;
      }
      const ElasticSolver::Step step = solver.conjugate_gradients();
      if (step.ended) {
        at_rest = step.at_rest;
        mistrust = at_rest ? "" : "moduli or springs differ so much that float32 has no further step";
        note("end", at_rest ? "what is left is rounding" : mistrust, 0.0, unknown);
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
    const bool is_estimated = at_rest || (error.is_known() && mistrust.empty());
    if (!std::isfinite(solver.rounding(1.0, contrast))) {
      mistrust = "moduli differ more than float32 can tell";
    }
    return is_estimated ? std::optional(error.is_known() ? error.estimate() : 0.0) : std::nullopt;
  };
  plan.solution = solve_image(scene, *session, progress, take);
  conclude(plan, scene, request, clock.seconds(), mistrust);
  return plan;
}

} // namespace hdmbench
