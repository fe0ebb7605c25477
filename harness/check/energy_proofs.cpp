// Built once per energy (kernels/specification/built_energy.hpp): what is proven of its arithmetic.

#include "harness/check/bounded_real.hpp"
#include "harness/check/certificate.hpp"
#include "harness/check/proven_real.hpp"
#include "harness/check/rewritten_real.hpp"
#include "kernels/data/gather.hpp"
#include "kernels/specification/built_energy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace hdmbench::energies::HDMBENCH_ENERGY {

extern const EnergyProofs proofs;

namespace {

template <typename Scalar, int axes>
using Arithmetic = ::hdmbench::HDMBENCH_ENERGY<Scalar, axes>;
/// Whose moves of one component are the same for any number of axes.
using Bounded = Arithmetic<bounded::real, 2>;

/// call<Energy>(), which has this scalar and as many axes as the level.
template <typename Scalar, typename Call>
auto with_axes_of(const Level& level, const Call& call) {
  return level.extent.axes() > 2 ? call.template operator()<Arithmetic<Scalar, 3>>()
                                 : call.template operator()<Arithmetic<Scalar, 2>>();
}

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

/// How far a component went from `before` to what a device found: the candidate where there is one, else the
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

float stored(float value) {
  return value;
}

template <typename Scalar>
SiteAnswer answer(const Level& level, const VectorField& before, int number, int x, int y, int z) {
  return with_axes_of<Scalar>(level, [&]<typename Energy>() {
    const typename Energy::Displacement next = swept_site<Energy>(level, before, number, x, y, z);
    SiteAnswer found{};
    for (std::size_t axis = 0; axis < Energy::axes; ++axis) {
      found[axis] = stored(next.*Energy::of_axis[axis].moved);
    }
    return found;
  });
}

/// Half the gradient of a component once those before it have gone their ways.
template <typename Energy>
bounded::real gradient_of(std::size_t axis, const typename Energy::Prior& prior,
                          const std::array<bounded::real, 3>& ways) {
  if constexpr (Energy::axes > 2) {
    if (axis == 2) {
      return Energy::gradient_after_both(prior, ways[0], ways[1]);
    }
  }
  return axis == 0 ? prior.gradient_x : Energy::gradient_after(prior, ways[0]);
}

/// A component is judged by where the device has put those before it.
Certificate certificate(const Level& level, const VectorField& before, int number, int x, int y, int z,
                        const SiteAnswer& found) {
  const SiteAnswer expected = answer<float>(level, before, number, x, y, z);
  const SweepState state = sweep_state(level, number);
  const int colours = sweeps_per_iteration(level);
  const std::size_t at = level.extent.index(x, y, z);
  return with_axes_of<bounded::real>(level, [&]<typename Energy>() {
    using InFloat = Arithmetic<float, Energy::axes>;
    const typename Energy::Site site = gather<Energy>(level, before, x, y, z);
    const typename Energy::Prior prior = Energy::prior_of(site);
    const typename InFloat::Sweep turn{state.colour, state.strength, state.number, state.seed};
    std::array<bounded::real, 3> ways;
    bool is_other = false;
    double largest = 0.0;
    for (std::size_t axis = 0; axis < Energy::axes; ++axis) {
      const auto& of = Energy::of_axis[axis];
      const bool differs = found[axis] != expected[axis];
      if (differs || (Energy::couples && is_other)) {
        const Component component{(site.*of.displacement).centre,
                                  gradient_of<Energy>(axis, prior, ways),
                                  prior.*of.curvature,
                                  site.*of.target,
                                  site.penalty * site.*of.confidence,
                                  site.*of.inverse_curvature};
        const bool moves = InFloat::of_axis[axis].moves(colours, InFloat::position_of(x, y, z), turn);
        largest =
            std::max(largest, moves ? judge(level, component, turn.strength, before[axis][at], found[axis])
                              : differs ? never
                                        : 0.0);
      }
      is_other = is_other || differs;
      ways[axis] = step_to(level, before[axis][at], found[axis]);
    }
    return Certificate{.holds = largest <= 1.0, .gap_over_bound = largest};
  });
}

std::optional<InexactOperation> inexact_operation(const Level& level, const VectorField& before, int number) {
  std::size_t at = 0;
  try {
    for (int z = 0; z < level.extent.depth; ++z) {
      for (int y = 0; y < level.extent.height; ++y) {
        for (int x = 0; x < level.extent.width; ++x, ++at) {
          proven::require_exact_inverse(level.modulus.values[at], level.inverse_modulus.values[at]);
          (void)with_axes_of<proven::real>(level, [&]<typename Energy>() {
            return swept_site<Energy>(level, before, number, x, y, z), 0;
          });
        }
      }
    }
  } catch (InexactOperation& found) {
    found.place = level.extent.place(at);
    found.sweep = number;
    return found;
  }
  return std::nullopt;
}

} // namespace

const EnergyProofs proofs{answer<float>, answer<rewritten::real>, certificate, inexact_operation};

} // namespace hdmbench::energies::HDMBENCH_ENERGY
