#include "harness/solve/methods/robust_observations.hpp"

#include "harness/solve/field_norms.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

constexpr int most_rounds = 50;
constexpr double least_move = 1e-3;   ///< of what is forgiven
constexpr double known_within = 0.02; ///< of what is forgiven: the field of a round
constexpr int most_steps = 30;        ///< of conjugate gradients, a round

/// Pixels, 0 where the component is no spring.
double way(const std::vector<float>& target, const std::vector<float>& confidence,
           const std::vector<float>& value, std::size_t site) {
  return is_spring(confidence[site]) ? static_cast<double>(target[site]) - static_cast<double>(value[site])
                                     : 0.0;
}

/// That of a spring `weight` times as stiff.
float weighted(float confidence, double weight) {
  if (!is_spring(confidence)) {
    return confidence;
  }
  const auto share = static_cast<double>(confidence);
  return static_cast<float>(weight * share / (1.0 - share + weight * share));
}

} // namespace

Level reweighted(const Level& full, const VectorField& displacement, double forgiven) {
  Level level = full;
  for (std::size_t site = 0; site < full.extent.sites(); ++site) {
    const double x = way(full.target.x, full.confidence.x, displacement.x, site);
    const double y = way(full.target.y, full.confidence.y, displacement.y, site);
    const double weight = 1.0 / std::sqrt(1.0 + (x * x + y * y) / (forgiven * forgiven));
    level.confidence.x[site] = weighted(full.confidence.x[site], weight);
    level.confidence.y[site] = weighted(full.confidence.y[site], weight);
  }
  return level;
}

void add_work(std::vector<LevelResult>& sum, const std::vector<LevelResult>& more) {
  if (sum.empty()) {
    sum = more;
    return;
  }
  for (std::size_t level = 0; level < sum.size(); ++level) {
    sum[level].iterations += more[level].iterations;
    sum[level].residuals += more[level].residuals;
  }
}

RobustObservations find_robust_observations(const Scene& scene, ElasticSession& session, Progress& progress) {
  const double forgiven = *scene.robust;
  if (!has_springs(scene.full)) {
    throw InputError(fmt::format("{} forgives observations beyond {:g} px, but has none that could be wrong: "
                                 "give some a confidence below 1, or leave out robust",
                                 scene.name, forgiven));
  }
  RobustObservations result{.level = scene.full};
  VectorField before;
  for (;;) {
    ElasticSolver solver(result.level, scene.poisson, session);
    solve_within(known_within * forgiven, most_steps, contrast_of(result.level.modulus), solver);
    ++result.rounds;
    const VectorField field = solver.displacement();
    result.timings.add(solver.timings());
    add_work(result.work, solver.work());
    if (result.rounds > 1) {
      result.moved = rms_difference(before, field);
    }
    progress.describe(fmt::format("{}: weights of observations, round {}", scene.name, result.rounds));
    if (result.rounds == most_rounds || (result.rounds > 1 && result.moved < least_move * forgiven)) {
      return result;
    }
    result.level = reweighted(scene.full, field, forgiven);
    before = field;
  }
}

} // namespace hdmbench
