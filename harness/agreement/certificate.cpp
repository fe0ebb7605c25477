#include "harness/agreement/certificate.hpp"

#include "harness/agreement/bounded_energy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace hdmbench {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// What one component of a site knows, in bounded arithmetic.
struct Component {
  bounded::real centre;
  bounded::real gradient;
  bounded::real curvature;
  bounded::real target;
  bounded::real confidence;
  bounded::real penalty; ///< K times confidence
  bounded::real inverse_curvature;
};

/// `excess` over `bound`; where the bound is 0, only what is `allowed` to be equal may be.
double share(double excess, double bound, bool allowed) {
  if (std::isnan(excess) || std::isnan(bound)) {
    return never;
  }
  if (bound > 0.0) {
    return std::max(0.0, excess / bound);
  }
  return excess < 0.0 || (excess == 0.0 && allowed) ? 0.0 : never;
}

/// By how much candidate `chosen` is dearer than any other, over what rounding explains. Among equals the
/// first one listed is the specified one.
double dearer(std::span<const bounded::real> changes, std::size_t chosen) {
  double largest = 0.0;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (i != chosen) {
      const double excess = changes[chosen].exact() - changes[i].exact();
      largest = std::max(largest, share(excess, changes[chosen].error() + changes[i].error(), chosen < i));
    }
  }
  return largest;
}

double judge_candidate(const Component& at, std::span<const float> steps, float before, float found) {
  std::vector<bounded::real> changes;
  changes.reserve(steps.size());
  for (const float step : steps) {
    changes.push_back(
        bounded::energy_change(step, at.gradient, at.curvature, at.target - at.centre, at.penalty));
  }
  double least = never; // several candidates may lead to the same float
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (before + steps[i] == found) {
      least = std::min(least, dearer(changes, i));
    }
  }
  return least;
}

/// The minimiser is the target, kept between two values that do not depend on it: what a target far away on
/// either side would give. The device is off by its error in these values, or, where it takes the wrong
/// branch, by its error in the remaining distance, to which target - centre and the distance itself add.
double judge_closed_form(const Component& at, float strength, float found) {
  constexpr float far_away = 1e30F;
  const auto with_target = [&](float target) {
    return bounded::closed_form(at.centre, at.gradient, at.inverse_curvature, target, at.penalty, strength);
  };
  const bounded::real low = with_target(-far_away);
  const bounded::real high = with_target(far_away);
  const double exact =
      std::clamp(at.target.exact(), std::min(low.exact(), high.exact()), std::max(low.exact(), high.exact()));
  const double value = std::max(low.error(), high.error());
  const double distance = std::abs(at.target.exact() - at.centre.exact());
  const double reach = std::abs(high.exact() - low.exact()) / 2.0;
  const double bound = value > 0.0 ? value + bounded::unit_roundoff * (distance + reach) : 0.0;
  return share(std::abs(static_cast<double>(found) - exact), bound, true);
}

double judge_correction(const Component& at, float strength, float found) {
  const bounded::real corrected =
      bounded::correction(at.centre, at.gradient, at.inverse_curvature, at.target, at.confidence, strength);
  return share(std::abs(static_cast<double>(found) - corrected.exact()), corrected.error(), true);
}

/// The share of one component's bound that separates `found` from the rule.
double judge(const Level& level, const Component& at, float strength, float before, float found) {
  switch (level.rule) {
  case Rule::steps:
    return judge_candidate(at, level.steps.values(), before, found);
  case Rule::closed_form:
    return judge_closed_form(at, strength, found);
  case Rule::correction:
    return judge_correction(at, strength, found);
  case Rule::annealing:
    break;
  }
  return never;
}

energy::Sweep turn_of(const Level& level, int number) {
  const SweepState state = sweep_state(level, number);
  return {state.colour, state.strength, state.number, state.seed};
}

} // namespace

SiteAnswer specified_answer(const Level& level, const VectorField& before, int number, int x, int y) {
  const energy::Displacement next = energy::swept_displacement(
      static_cast<int>(level.rule), sweeps_per_iteration(level.update), energy::gather(level, before, x, y),
      {static_cast<float>(x), static_cast<float>(y)}, turn_of(level, number), level.steps.padded().data(),
      level.steps.count());
  return {next.x, next.y};
}

Certificate certify(const Level& level, const VectorField& before, int number, int x, int y,
                    SiteAnswer found) {
  const SiteAnswer expected = specified_answer(level, before, number, x, y);
  const bounded::Site site = bounded::gather(level, before, x, y, bounded::InverseModulus::given);
  const bounded::Parabolas prior = bounded::prior_parabolas(site);
  const energy::Sweep turn = turn_of(level, number);
  const energy::Position position{static_cast<float>(x), static_cast<float>(y)};
  const int colours = sweeps_per_iteration(level.update);
  const std::size_t i = level.extent.index(x, y);

  double share_x = 0.0;
  double share_y = 0.0;
  if (found.x != expected.x) {
    const Component component{site.dx.centre,          prior.gradient_x,  prior.curvature_x,
                              site.target_x,           site.confidence_x, site.penalty * site.confidence_x,
                              site.inverse_curvature_x};
    const bool moves = energy::moves_x(colours, position, turn);
    share_x = moves ? judge(level, component, turn.strength, before.x[i], found.x) : never;
  }
  if (found.y != expected.y) {
    const Component component{site.dy.centre,          prior.gradient_y,  prior.curvature_y,
                              site.target_y,           site.confidence_y, site.penalty * site.confidence_y,
                              site.inverse_curvature_y};
    const bool moves = energy::moves_y(colours, position, turn);
    share_y = moves ? judge(level, component, turn.strength, before.y[i], found.y) : never;
  }
  const double largest = std::max(share_x, share_y);
  return {.holds = largest <= 1.0, .gap_over_bound = largest};
}

} // namespace hdmbench
