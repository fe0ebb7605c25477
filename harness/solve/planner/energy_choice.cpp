#include "harness/solve/planner/energy_choice.hpp"

#include "harness/scene/method.hpp"
#include "harness/solve/field_norms.hpp"
#include "harness/solve/methods/sampled_image.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/pyramid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace hdmbench {

namespace {

/// Sites a side of the image on which the energies are compared: some milliseconds.
constexpr int compared_sites = 96;

/// What the energies' own solutions may be wrong by on it, as a share of the accuracy asked for.
constexpr double share_of_comparison = 0.1;

/// The thesis's energy may end this share of the accuracy away from finite elements, and be found to end at a
/// half of it: a sampled image does not show all of the way.
constexpr double share_of_model = 0.5;
constexpr double caution_before_model = 2.0;

constexpr const char* truth = "finite elements";
constexpr double least_seconds = 1e-9; ///< a request must be above 0

struct Comparison {
  Extent extent{};         ///< of the image it was made on
  VectorField elastic{};   ///< displacement on it, pixels
  double difference = 0.0; ///< RMS of the way between the energies' displacements, pixels
  bool enough = false;     ///< the thesis's energy is
  std::string reason{};
};

Comparison compare(const Scene& scene, double accuracy, const Backend& backend, const SessionOptions& options,
                   std::vector<std::unique_ptr<Session>>& sessions, Progress& progress) {
  const int longer = std::max(scene.extent().width, scene.extent().height);
  const int stride = (longer + compared_sites - 1) / compared_sites;
  const BlockModuli blocks = block_moduli(scene.full.modulus, scene.full.inverse_modulus,
                                          sampled_extent(scene.extent(), stride), scene.schedule.alignment);
  Comparison result{.extent = blocks.mean.extent};
  if (largest_mixture(blocks) > most_mixed) {
    result.reason = "what is thinner than a cell matters too much to compare the energies: the elastic one";
    return result;
  }
  const auto solve_by = [&](const Method& method, BlockMean mean) {
    Scene sampled = sampled_scene(scene, blocks, mean);
    use_method(sampled, method);
    return solve_as_needed(sampled, {.accuracy = share_of_comparison * accuracy}, backend, options, sessions,
                           progress);
  };
  const Method& elastic_method = usual_method(EnergyModel::elastic);
  Plan elastic = solve_by(elastic_method, BlockMean::geometric);
  const Plan simple = solve_by(find_method("multigrid"), BlockMean::geometric);
  const double enough = share_of_model * accuracy / caution_before_model;
  result.difference = rms_difference(elastic.solution.displacement, simple.solution.displacement);
  result.enough = simple.met && elastic.met && result.difference <= enough;
  if (result.enough && stride > 1) {
    const Plan upper = solve_by(elastic_method, BlockMean::arithmetic);
    result.difference = std::hypot(
        result.difference, rms_difference(upper.solution.displacement, elastic.solution.displacement));
    result.enough = upper.met && result.difference <= enough;
  }
  result.elastic = std::move(elastic.solution.displacement);
  result.reason = !simple.met
                      ? std::string("the thesis's energy promises nothing here: the elastic one")
                      : fmt::format("the thesis's energy ends {:.2g} px from the elastic one, which {}",
                                    result.difference, result.enough ? "is near enough" : "is taken");
  return result;
}

} // namespace

Plan solve_by_either_energy(Scene& scene, const Request& request, const Backend& backend,
                            const SessionOptions& options, std::vector<std::unique_ptr<Session>>& sessions,
                            Progress& progress) {
  if (!request.accuracy) {
    throw InputError("no accuracy is asked for, by which to choose an energy");
  }
  if (std::optional<Scene> scaled = with_safe_moduli(scene)) {
    Plan plan = solve_by_either_energy(*scaled, request, backend, options, sessions, progress);
    std::swap(scaled->full.modulus, scene.full.modulus);
    std::swap(scaled->full.inverse_modulus, scene.full.inverse_modulus);
    scene = std::move(*scaled);
    return plan;
  }
  const Clock clock;
  const bool sprung = has_springs(scene.full);
  const Comparison comparison =
      sprung ? Comparison{.reason = "uncertain observations are springs of the elastic energy"}
             : compare(scene, *request.accuracy, backend, options, sessions, progress);
  std::vector<PlanStep> steps{{.extent = sprung ? scene.extent() : comparison.extent,
                               .action = "energy",
                               .reason = comparison.reason,
                               .moved = comparison.difference,
                               .expected_error = std::numeric_limits<double>::infinity(),
                               .seconds = clock.seconds()}};
  const auto solve = [&](const Method& method, std::optional<double> accuracy) {
    const double begin = clock.seconds();
    use_method(scene, method);
    Request left{.accuracy = accuracy};
    if (request.seconds) {
      left.seconds = std::max(*request.seconds - begin, least_seconds);
    }
    Plan plan = solve_as_needed(scene, left, backend, options, sessions, progress);
    for (PlanStep& step : plan.steps) {
      step.seconds += begin;
    }
    steps.insert(steps.end(), plan.steps.begin(), plan.steps.end());
    plan.steps = steps;
    return plan;
  };
  if (comparison.enough) {
    Plan plan = solve(find_method("multigrid"), (1.0 - share_of_model) * *request.accuracy);
    // What is one pixel wide the sampled image has spread, and the thesis's energy sees it only now.
    const double apart =
        rms_difference(sample_field(plan.solution.displacement, comparison.extent, scene.schedule.alignment),
                       comparison.elastic);
    if (plan.met && apart <= share_of_model * *request.accuracy) {
      *plan.solution.estimated_error += std::max(comparison.difference, apart);
      conclude(plan, scene, request, clock.seconds(), truth);
      return plan;
    }
    steps.push_back({.extent = comparison.extent,
                     .action = "energy",
                     .reason = fmt::format("the thesis's energy ended {:.2g} px from the elastic one", apart),
                     .moved = apart,
                     .expected_error = std::numeric_limits<double>::infinity(),
                     .seconds = clock.seconds()});
  }
  Plan plan = solve(usual_method(EnergyModel::elastic), request.accuracy);
  conclude(plan, scene, request, clock.seconds(), truth);
  return plan;
}

} // namespace hdmbench
