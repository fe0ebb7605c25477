#include "harness/check/whole_method.hpp"

#include "harness/check/compare.hpp"
#include "harness/check/follower.hpp"
#include "harness/solve/methods/multigrid.hpp"
#include "harness/solve/methods/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

/// Only the displacement is known of both, so no rounding explains a difference.
Comparison compared(const Scene& scene, const Solution& expected, std::optional<double> residual,
                    const Backend& backend, const WholeMethod::Solved& solved, const VerifyOptions& options) {
  const VectorField& found = solved.displacement;
  Comparison comparison{.backend = std::string(backend.name()),
                        .device = backend.device(options.session),
                        .mode = Mode::pyramid,
                        .levels = static_cast<int>(expected.levels.size()),
                        .iterations = total_iterations(expected.levels),
                        .sweeps = total_iterations(expected.levels) * sweeps_per_iteration(scene.full),
                        .counts_differing = solved.residual == residual ? 0 : 1};
  count_end(comparison, compare(expected.displacement, found), found.extent, false, [&](std::size_t site) {
    FirstDifference first = difference_at(site, expected.displacement, found);
    first.iteration = expected.levels.back().iterations;
    return first;
  });
  conclude(comparison,
           {.why_mistrusted = why_mistrusted(scene, largest_magnitude(expected.displacement) > 0.0)});
  return comparison;
}

} // namespace

bool is_compared_whole(const Scene& scene) {
  return scene.energy == EnergyModel::hdm &&
         (scene.schedule.cycle != Cycle::one_way || scene.schedule.mean_modulus);
}

std::vector<Comparison> verify_whole(const Scene& scene, const Backend& reference,
                                     std::span<const Backend* const> backends, const VerifyOptions& options,
                                     Progress& progress) {
  const auto is_whole = [](const Backend* backend) {
    return dynamic_cast<const WholeMethod*>(backend) != nullptr;
  };
  if (std::ranges::none_of(backends, is_whole)) {
    return {};
  }
  Progress silent(false);
  progress.describe(fmt::format("verify {}, {}: as a whole", scene.name, method_name(scene)));
  Solution expected;
  std::optional<double> residual;
  if (scene.schedule.cycle == Cycle::one_way) {
    expected = Solver(reference, options.session).solve(scene, silent);
  } else {
    CycleSolution solution = solve_on_parts(scene, reference, options.session, whole_image(), silent);
    residual = solution.residual;
    expected = std::move(solution);
  }
  std::vector<Comparison> comparisons;
  for (const Backend* const backend : backends) {
    if (const auto* const whole = dynamic_cast<const WholeMethod*>(backend)) {
      comparisons.push_back(compared(scene, expected, residual, *backend, whole->solve(scene), options));
    }
  }
  return comparisons;
}

} // namespace hdmbench
