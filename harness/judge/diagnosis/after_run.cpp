#include "harness/judge/diagnosis/deformation.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/diagnosis/measures.hpp"
#include "harness/scene/joined.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

using namespace diagnosis;

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
    std::size_t beyond = 0;
    double farthest = 0.0;
    std::size_t worst = 0;
    const auto& values = displacement.*component.part;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double value = static_cast<double>(values[i]);
      const double way = std::max(range.least - value, value - range.most);
      beyond += way > allowed ? 1 : 0;
      worst = way > farthest ? i : worst;
      farthest = std::max(farthest, way);
    }
    if (beyond > 0) {
      warnings.push_back(
          {"divergence",
           fmt::format(
               "{} sites lie outside {:.4g} ... {:.4g} px, which conditions and start allow in {}; the "
               "worst by {:.3g} px, at {}",
               beyond, range.least, range.most, component.name, farthest, place(scene.extent(), worst)),
           "--method icm; accelerated sweeps can grow where moduli differ much", beyond});
    }
  }
}

/// Components of confidence 1 that are off their targets by more than the rule can help. A candidate e is
/// taken towards a target that is w > e / 2 away where K (2 w - e) exceeds the prior's A e^2 + 2 |g| e. Where
/// the prior pulls as hard as the observation, |g| = K / 2 to what a candidate changes it by, A e, no further
/// sweep brings the component nearer.
void check_met(const Scene& scene, const VectorField& displacement, Warnings& warnings) {
  const Extent extent = scene.extent();
  const double step = quantum(scene);
  const double chance = scene.schedule.rule == Rule::annealing ? 0.5 * step : 0.0;
  const double penalty = static_cast<double>(scene.full.penalty);
  struct Missed {
    std::size_t count = 0;
    double farthest = 0.0;
    std::size_t worst = 0;
    void add(double way, std::size_t site) {
      ++count;
      worst = way > farthest ? site : worst;
      farthest = std::max(farthest, way);
    }
  };
  Missed overruled;
  Missed not_arrived;
  for_each_site(extent, [&](int x, int y) {
    const std::size_t at = extent.index(x, y);
    const auto check = [&](float confidence, float target, float centre, float gradient, float curvature) {
      const double way = std::abs(static_cast<double>(target) - static_cast<double>(centre));
      const double change = static_cast<double>(curvature) * step;
      const double pull = std::abs(static_cast<double>(gradient));
      const double allowed = 0.5 * step + chance + (change + 2.0 * pull) * step / (2.0 * penalty) + 1e-3;
      if (confidence == 1.0F && way > allowed) {
        (pull + change >= 0.499 * penalty ? overruled : not_arrived).add(way, at);
      }
    };
    const Level& level = scene.full;
    const PriorAtSite prior = level.energy->host->prior(level, displacement, x, y);
    check(level.confidence.x[at], level.target.x[at], displacement.x[at], prior.gradient_x,
          prior.curvature_x);
    check(level.confidence.y[at], level.target.y[at], displacement.y[at], prior.gradient_y,
          prior.curvature_y);
  });
  const auto warn = [&](const Missed& missed, const char* kind, const char* why, const char* advice) {
    if (missed.count > 0) {
      warnings.push_back({kind,
                          fmt::format("{} certain conditions {}; the farthest is {:.3g} px off, at {}",
                                      missed.count, why, missed.farthest, place(extent, missed.worst)),
                          advice, missed.count});
    }
  };
  warn(overruled, "gives-way", "are overruled by the tissue around them, which pulls harder than K",
       "a larger --penalty; look for conditions that contradict each other");
  warn(not_arrived, "not-met", "have not been arrived at",
       "more --iterations, or --energy elastic, which starts from met conditions");
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

void check_folding(const VectorField& displacement, Warnings& warnings) {
  // A tenth of the area left: from here on linear interpolation of what moved there is unreliable.
  constexpr float nearly_folded = 0.1F;
  const ScalarField ratios = least_area_ratios(displacement);
  if (ratios.values.empty()) {
    return;
  }
  const auto worst = std::ranges::min_element(ratios.values);
  const std::string where = place(ratios.extent, static_cast<std::size_t>(worst - ratios.values.begin()));
  const auto cells_where = [&](auto holds) {
    return static_cast<std::size_t>(std::ranges::count_if(ratios.values, holds));
  };
  const std::size_t folded = cells_where([](float ratio) { return ratio <= 0.0F; });
  const std::size_t near = cells_where([](float ratio) { return ratio < nearly_folded; }) - folded;
  if (folded > 0) {
    warnings.push_back(
        {"fold-over",
         fmt::format(
             "the image is turned over in {} of {} cells between sites (det(I + grad d) <= 0), and {} "
             "more keep less than a tenth of their area; worst {:.3g} at {}",
             folded, ratios.values.size(), near, *worst, where),
         "smaller displacements, or a wider way for them to fade out; the picture \"jacobian\" shows where",
         folded});
  } else if (near > 0) {
    warnings.push_back(
        {"near-fold",
         fmt::format("{} of {} cells between sites keep less than a tenth of their area; least {:.3g} at {}",
                     near, ratios.values.size(), *worst, where),
         "look at the picture \"jacobian\" before you trust what moved there", near});
  }
}

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
    warnings.push_back(
        {"oscillation",
         fmt::format("{} of the {} sites that still move swap between two values for ever, past "
                     "neighbours that move at the same time",
                     rest.swapping, rest.moving),
         "--method coloured (neighbours in turn) or --method cascade", rest.swapping});
  } else if (stripes) {
    warnings.push_back(
        {"oscillation",
         fmt::format(
             "{:.0f} % of what is missing alternates from column to column (y: row to row), {:.2g} px "
             "RMS: simultaneous sweeps hardly damp such stripes",
             100.0 * std::min(1.0, rest.stripes_share), rest.stripes),
         "--method cascade, which moves neighbours in turn"});
  }
  const double distance = estimated_distance(scene, rest.missing);
  const std::string adds_up = fmt::format(
      "sites are {:.2g} px (RMS) from their own minimum, about {:.2g} px from the fixed point in all",
      rest.rms, distance);
  const std::size_t left = rest.moving - rest.swapping;
  if (many(left) || (smallest == 0.0 && distance > visible)) {
    warnings.push_back({"still-moving", "the sweeps ended before the field came to rest: " + adds_up,
                        "more --iterations, --stop still with a high --iterations, or --energy elastic",
                        smallest > 0.0 ? std::optional(left) : std::nullopt});
  } else if (distance > visible) {
    warnings.push_back({"stalled",
                        fmt::format("at rest, but only to candidates of {:.3g} px: {}", smallest, adds_up),
                        "--steps fine (candidates down to 0.01 px), --method cascade, or --energy elastic"});
  }
}

void check_elastic_rest(const Scene& scene, const Solution& solution, Warnings& warnings) {
  const Schedule& schedule = scene.schedule;
  const std::string& method = schedule.method;
  const std::optional<double>& estimate = solution.estimated_error;
  const bool stalls = method == elastic_conjugate_gradients && schedule.iterations > 0;
  if (schedule.stride > 1) {
    warnings.push_back(
        {"no-estimate",
         fmt::format("what it costs to sample every {} pixel was not estimated", ordinal(schedule.stride)),
         "--accuracy in place of --stride, which chooses the stride and estimates"});
  } else if (!estimate) {
    warnings.push_back(
        {"no-estimate",
         stalls ? "conjugate gradients ended where float32 had no further step, not where nothing was left"
                : fmt::format("the method {} did not estimate how far its field is from finite elements",
                              method),
         stalls ? "moduli, springs or targets that differ less, and are not near the limits of float32"
                : "--method conjugate-gradients with --iterations 2 or more"});
  } else if (!(*estimate <= visible)) {
    warnings.push_back(
        {"not-converged",
         fmt::format("the method {} estimates {:.2g} px to finite elements", method, *estimate),
         "--method conjugate-gradients with more --iterations"});
  }
}

} // namespace

Warnings diagnose(const Scene& scene, const Solution& solution) {
  Warnings warnings;
  const VectorField& field = solution.displacement;
  const auto is_wild = [](float value) { return !std::isfinite(value); };
  const auto wild = static_cast<std::size_t>(std::ranges::count_if(field.x, is_wild) +
                                             std::ranges::count_if(field.y, is_wild));
  if (wild > 0) {
    return {{"not-finite",
             fmt::format("{} components are infinite or not a number: the sweeps blew up", wild),
             "--method icm; look for extreme moduli, targets or a huge --penalty", wild}};
  }
  if (scene.energy->is_of_cells()) {
    if (const std::string absurd = why_absurd(scene, field); !absurd.empty()) {
      return {{"divergence", absurd, "--method full-multigrid; look for extreme moduli or targets"}};
    }
    check_folding(field, warnings);
    check_elastic_rest(scene, solution, warnings);
    return warnings;
  }
  check_range(scene, field, warnings);
  check_folding(field, warnings);
  check_met(scene, field, warnings);
  check_rest(scene, solution, warnings);
  return warnings;
}

} // namespace hdmbench
