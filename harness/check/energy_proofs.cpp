// Built once per energy (kernels/specification/built_energy.hpp): what is proven of its arithmetic.

#include "harness/check/bounded_real.hpp"
#include "harness/check/certificate.hpp"
#include "harness/check/fused_real.hpp"
#include "harness/check/proven_real.hpp"
#include "kernels/data/gather.hpp"
#include "kernels/specification/built_energy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace hdmbench::energies::HDMBENCH_ENERGY {

extern const EnergyProofs proofs;

namespace {

using InFloat = ::hdmbench::HDMBENCH_ENERGY<float>;
using Bounded = ::hdmbench::HDMBENCH_ENERGY<bounded::real>;
using Proven = ::hdmbench::HDMBENCH_ENERGY<proven::real>;
using Fused = ::hdmbench::HDMBENCH_ENERGY<fused::real>;

constexpr double never = std::numeric_limits<double>::infinity();

/// What one component of a site knows, in bounded arithmetic.
struct Component {
  bounded::real centre;
  bounded::real gradient;
  bounded::real curvature;
  bounded::real target;
  bounded::real penalty; ///< K times the confidence
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

/// Returns by how much the energy of candidate `chosen` is above that of any other, as a share of what
/// rounding explains. Among equals the first one listed is the specified one.
double energy_excess(std::span<const bounded::real> changes, std::size_t chosen) {
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
        Bounded::energy_change(step, at.gradient, at.curvature, at.target - at.centre, at.penalty));
  }
  double least = never; // several candidates may lead to the same float
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (before + steps[i] == found) {
      least = std::min(least, energy_excess(changes, i));
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
    return Bounded::closed_form(at.centre, at.gradient, at.inverse_curvature, target, at.penalty, strength);
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

/// The share of one component's bound that separates `found` from the rule.
double judge(const Level& level, const Component& at, float strength, float before, float found) {
  switch (level.rule) {
  case Rule::steps:
    return judge_candidate(at, level.steps.values(), before, found);
  case Rule::closed_form:
    return judge_closed_form(at, strength, found);
  case Rule::annealing:
    break;
  }
  return never;
}

/// How far x went from `before` to what a device found: the candidate where there is one, else the
/// difference.
bounded::real step_to(const Level& level, float before, float found) {
  if (level.rule == Rule::steps) {
    for (const float step : level.steps.values()) {
      if (before + step == found) {
        return step;
      }
    }
  }
  return bounded::real(found) - bounded::real(before);
}

SiteAnswer answer(const Level& level, const VectorField& before, int number, int x, int y) {
  const InFloat::Displacement next = swept_site<InFloat>(level, before, number, x, y);
  return {next.x, next.y};
}

SiteAnswer answer_if_fused(const Level& level, const VectorField& before, int number, int x, int y) {
  const Fused::Displacement next = swept_site<Fused>(level, before, number, x, y);
  return {next.x.value, next.y.value};
}

/// y is judged by where the device has put x.
Certificate certificate(const Level& level, const VectorField& before, int number, int x, int y,
                        SiteAnswer found) {
  const SiteAnswer expected = answer(level, before, number, x, y);
  const Bounded::Site site = gather<Bounded>(level, before, x, y);
  const Bounded::Prior prior = Bounded::prior_of(site);
  const SweepState state = sweep_state(level, number);
  const InFloat::Sweep turn{state.colour, state.strength, state.number, state.seed};
  const InFloat::Position position{static_cast<float>(x), static_cast<float>(y)};
  const int colours = sweeps_per_iteration(level);
  const std::size_t i = level.extent.index(x, y);

  double share_x = 0.0;
  double share_y = 0.0;
  if (found.x != expected.x) {
    const Component component{site.dx.centre,
                              prior.gradient_x,
                              prior.curvature_x,
                              site.target_x,
                              site.penalty * site.confidence_x,
                              site.inverse_curvature_x};
    const bool moves = InFloat::moves_x(colours, position, turn);
    share_x = moves ? judge(level, component, turn.strength, before[0][i], found.x) : never;
  }
  if (found.y != expected.y || (InFloat::couples && found.x != expected.x)) {
    const Component component{site.dy.centre,
                              Bounded::gradient_after(prior, step_to(level, before[0][i], found.x)),
                              prior.curvature_y,
                              site.target_y,
                              site.penalty * site.confidence_y,
                              site.inverse_curvature_y};
    const bool moves = InFloat::moves_y(colours, position, turn);
    share_y = moves                   ? judge(level, component, turn.strength, before[1][i], found.y)
              : found.y == expected.y ? 0.0
                                      : never;
  }
  const double largest = std::max(share_x, share_y);
  return {.holds = largest <= 1.0, .gap_over_bound = largest};
}

std::optional<InexactOperation> inexact_operation(const Level& level, const VectorField& before, int number) {
  int x = 0;
  int y = 0;
  try {
    for (y = 0; y < level.extent.height; ++y) {
      for (x = 0; x < level.extent.width; ++x) {
        const std::size_t at = level.extent.index(x, y);
        proven::require_exact_inverse(level.modulus.values[at], level.inverse_modulus.values[at]);
        (void)swept_site<Proven>(level, before, number, x, y);
      }
    }
  } catch (InexactOperation& found) {
    found.x = x;
    found.y = y;
    found.sweep = number;
    return found;
  }
  return std::nullopt;
}

} // namespace

const EnergyProofs proofs{answer, answer_if_fused, certificate, inexact_operation};

} // namespace hdmbench::energies::HDMBENCH_ENERGY
