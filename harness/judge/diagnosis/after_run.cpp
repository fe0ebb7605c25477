#include "harness/judge/diagnosis/measures.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/interruption.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

namespace hdmbench {

using namespace diagnosis;
using namespace fmt::literals;

namespace {

/// Distances to the fixed point from here on are worth a warning: a tenth of a pixel, the thesis's candidate.
constexpr double visible = 0.1;

/// The fixed point lies between the smallest and the largest target (every equation makes a component a mean
/// of its neighbours), so whatever is beyond, and was not so at the start, is at least that far from it. A
/// candidate may overshoot by half the largest one, a neighbour of that by another half.
void check_range(const Scene& scene, const VectorField& displacement, Warnings& warnings) {
  const double allowed = scene.schedule.rule == Rule::steps || scene.schedule.rule == Rule::annealing
                             ? std::max(visible, step_sizes(scene.full.steps).largest)
                             : visible;
  for (const Component& component : components(scene)) {
    Range range = component.known;
    for (std::size_t i = 0; i < component.target.size(); ++i) {
      range.include(component.start_of(i));
    }
    Seen beyond;
    const auto& values = displacement[component.axis];
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double value = static_cast<double>(values[i]);
      const double way = std::max(range.least - value, value - range.most);
      if (way > allowed) {
        beyond.add(way, i);
      }
    }
    if (beyond.count > 0) {
      warn(warnings, "divergence", beyond.count, "least"_a = range.least, "most"_a = range.most,
           "component"_a = component.name, "farthest"_a = beyond.most,
           "place"_a = scene.extent().place(beyond.worst));
    }
  }
}

/// Components of confidence 1 that are off their targets by more than the rule can help. A candidate e is
/// taken towards a target that is w > e / 2 away where K (2 w - e) exceeds the prior's A e^2 + 2 |g| e. Where
/// the prior pulls as hard as the observation, |g| = K / 2 to what a candidate changes it by, A e, no further
/// sweep brings the component nearer.
void check_met(const Scene& scene, const VectorField& displacement, Warnings& warnings) {
  const Level& level = scene.full;
  const Extent extent = level.extent;
  const double step = quantum(scene);
  const double chance = scene.schedule.rule == Rule::annealing ? 0.5 * step : 0.0;
  const double penalty = static_cast<double>(level.penalty);
  struct Missed {
    Seen overruled;
    Seen not_arrived;
  };
  const auto look_at = [&](std::size_t at, std::size_t axis, const PriorAtSite& prior, Missed& missed) {
    const double way = std::abs(double{level.target[axis][at]} - double{displacement[axis][at]});
    const double change = double{prior.curvature[axis]} * step;
    const double pull = std::abs(double{prior.gradient[axis]});
    const double allowed = 0.5 * step + chance + (change + 2.0 * pull) * step / (2.0 * penalty) + 1e-3;
    if (way > allowed) {
      (pull + change >= 0.499 * penalty ? missed.overruled : missed.not_arrived).add(way, at);
    }
  };
  std::vector<Missed> of_rows(static_cast<std::size_t>(extent.rows()));
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t at = extent.index(x, row);
      std::optional<PriorAtSite> prior;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        if (level.confidence[axis][at] == 1.0F) {
          prior = prior ? prior
                        : level.energy->host->prior(level, displacement, x, row % extent.height,
                                                    row / extent.height);
          look_at(at, axis, *prior, of_rows[static_cast<std::size_t>(row)]);
        }
      }
    }
  }
  Missed all;
  for (const Missed& of_row : of_rows) {
    all.overruled.add(of_row.overruled);
    all.not_arrived.add(of_row.not_arrived);
  }
  for (const auto& [kind, missed] : {std::pair("gives-way", all.overruled), {"not-met", all.not_arrived}}) {
    if (missed.count > 0) {
      warn(warnings, kind, missed.count, "farthest"_a = missed.most, "place"_a = extent.place(missed.worst));
    }
  }
}

/// accumulated_distance, but no more than conditions are apart: no two fields between them are farther.
double estimated_distance(const Scene& scene, const VectorField& missing) {
  double square = 0.0;
  for (const Component& component : components(scene)) {
    square += std::pow(component.known.width(), 2.0);
  }
  const double estimate = accumulated_distance(scene, missing);
  return square > 0.0 ? std::min(estimate, std::sqrt(square)) : estimate;
}

/// Laws of large strains have less and less against being dilated where Poisson's ratio is near 0: a volume
/// gives way from 2.7 times its size on at 0, from 3 times at .01, and nowhere from .05 on
/// (kernels/specification/laws).
void check_dilation(const Scene& scene, const VectorField& steps, Warnings& warnings) {
  constexpr double safe_poisson = 0.05;
  constexpr float most = 2.5F;
  const Level& body = scene.full;
  if (!has_laws(body) || body.extent.axes() == 2 || scene.elastic.poisson >= safe_poisson) {
    return;
  }
  ScalarField with_law(body.extent);
  std::ranges::transform(body.modulus.values, body.law_parameter.values, with_law.values.begin(),
                         [least = void_modulus(body)](float modulus, float parameter) {
                           return modulus < least || parameter < 0.0F ? 0.0F : 1.0F;
                         });
  const ScalarField ratios = least_area_ratios(steps, with_law);
  Seen dilated;
  for (std::size_t cell = 0; cell < ratios.values.size(); ++cell) {
    if (ratios.values[cell] > most) {
      dilated.add(ratios.values[cell], cell);
    }
  }
  if (dilated.count > 0) {
    warn(warnings, "dilated", dilated.count, "poisson"_a = scene.elastic.poisson, "most"_a = dilated.most,
         "place"_a = ratios.extent.place(dilated.worst));
  }
}

} // namespace

Warnings diagnose(const VectorField& displacement, const ScalarField& tissue) {
  Warnings warnings;
  // A tenth of the area left: from here on linear interpolation of what moved there is unreliable.
  constexpr float nearly_folded = 0.1F;
  const ScalarField ratios = least_area_ratios(displacement, tissue);
  if (ratios.values.empty()) {
    return warnings;
  }
  const auto worst = std::ranges::min_element(ratios.values);
  const std::string where = ratios.extent.place(static_cast<std::size_t>(worst - ratios.values.begin()));
  const auto cells_where = [&](auto holds) {
    return static_cast<std::size_t>(std::ranges::count_if(ratios.values, holds));
  };
  const std::size_t folded = cells_where([](float ratio) { return ratio <= 0.0F; });
  const std::size_t near = cells_where([](float ratio) { return ratio < nearly_folded; }) - folded;
  if (folded + near > 0) {
    warn(warnings, folded > 0 ? "fold-over" : "near-fold", folded > 0 ? folded : near,
         "cells"_a = ratios.values.size(), "near"_a = near, "least"_a = *worst, "place"_a = where,
         "content"_a = displacement.extent.depth > 1 ? "volume" : "area");
  }
  return warnings;
}

namespace {

void check_rest(const Scene& scene, const Solution& solution, Warnings& warnings) {
  const RestState rest = measure_rest(scene, solution.displacement);
  const std::size_t sites = scene.extent().sites();
  // Moving by e at a share p of the sites is an RMSD of e sqrt(p): up to a hundredth of the sites that is
  // less than a tenth of a candidate.
  const auto many = [&](std::size_t count) { return count * 100 > sites; };
  const double smallest = quantum(scene);
  const bool never_still =
      scene.schedule.stop == Stop::still && rest.moving > 0 && rest.swapping == rest.moving;
  const bool swaps = scene.full.update == Update::simultaneous && (many(rest.swapping) || never_still);
  // Between noise, 3/8, and stripes, 1.
  const bool stripes = rest.stripes_share > 11.0 / 16.0 && rest.stripes > std::max(0.5 * smallest, 0.01);
  if (swaps) {
    warn(warnings, "oscillation", rest.swapping, "moving"_a = rest.moving);
  } else if (stripes) {
    warn(warnings, "oscillation/stripes", std::nullopt,
         "percent"_a = 100.0 * std::min(1.0, rest.stripes_share), "stripes"_a = rest.stripes);
  }
  const double distance = estimated_distance(scene, rest.missing);
  const std::size_t left = rest.moving - rest.swapping;
  if (many(left) || (smallest == 0.0 && distance > visible)) {
    warn(warnings, "still-moving", smallest > 0.0 ? std::optional(left) : std::nullopt, "rms"_a = rest.rms,
         "distance"_a = distance);
  } else if (distance > visible) {
    warn(warnings, "stalled", std::nullopt, "smallest"_a = smallest, "rms"_a = rest.rms,
         "distance"_a = distance);
  }
}

void check_elastic_rest(const Scene& scene, const Solution& solution, Warnings& warnings) {
  const Schedule& schedule = scene.schedule;
  const std::string& method = schedule.method;
  const std::optional<double>& estimate = solution.estimated_error;
  if (const std::string part = floating_part(scene.full); !part.empty()) {
    warn(warnings, "no-estimate/floating", std::nullopt, "part"_a = part);
  } else if (!estimate) {
    const bool stalls = method == elastic_conjugate_gradients && schedule.iterations > 0;
    warn(warnings, stalls ? "no-estimate/float32" : "no-estimate", std::nullopt, "method"_a = method);
  } else if (!(*estimate <= visible)) {
    warn(warnings, "not-converged", std::nullopt, "method"_a = method, "distance"_a = *estimate);
  }
}

} // namespace

Warnings diagnose(const Scene& scene, const Solution& solution) {
  Warnings warnings;
  const VectorField& field = solution.displacement;
  const auto is_wild = [](float value) { return !std::isfinite(value); };
  std::size_t wild = 0;
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    wild += static_cast<std::size_t>(std::ranges::count_if(field[axis], is_wild));
  }
  const auto check_folds = [&] {
    const std::optional<VectorField> steps = in_steps(field, scene.full.sides);
    std::ranges::move(diagnose(steps ? *steps : field, tissue_of(scene)), std::back_inserter(warnings));
    check_dilation(scene, steps ? *steps : field, warnings);
  };
  if (wild > 0) {
    warn(warnings, scene.energy->is_of_cells() ? "not-finite/elastic" : "not-finite", wild);
  } else if (!scene.energy->is_of_cells()) {
    check_range(scene, field, warnings);
    check_folds();
    check_met(scene, field, warnings);
    check_rest(scene, solution, warnings);
  } else if (const std::string absurd = why_absurd(scene, solution); !absurd.empty()) {
    warn(warnings, has_laws(scene.full) ? "divergence/laws" : "divergence/elastic", std::nullopt,
         "why"_a = absurd);
  } else {
    if (!solution.beyond_law.empty()) {
      warn(warnings, "beyond-law", std::nullopt, "why"_a = solution.beyond_law);
    }
    if (!solution.buckling.empty()) {
      warn(warnings, "buckling", std::nullopt, "why"_a = solution.buckling);
    } else if (!solution.gave_way_at.empty()) {
      warn(warnings, "gave-way", std::nullopt, "place"_a = solution.gave_way_at);
    }
    check_folds();
    check_elastic_rest(scene, solution, warnings);
  }
  return without_what_is_given(std::move(warnings), scene);
}

Warnings diagnose(const Scene& scene, const Solution& solution, const std::optional<Plan>& plan) {
  Warnings warnings;
  if (is_inspected(scene.extent())) {
    warnings = diagnose(scene);
    may_end_here();
    std::ranges::move(diagnose(scene, solution), std::back_inserter(warnings));
  }
  constexpr std::array of_methods{"no-estimate", "stalling-cycles", "nearly-incompressible"};
  std::erase_if(warnings, [&](const Warning& warning) {
    return plan && (std::ranges::count(of_methods, warning.kind) > 0 ||
                    (plan->met && warning.kind == "not-converged"));
  });
  return warnings;
}

} // namespace hdmbench
