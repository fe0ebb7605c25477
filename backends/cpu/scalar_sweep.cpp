// Built once per energy (built_energy.hpp), with plain -O2: the specification read aloud, one site after the
// other.

#include "kernels/data/gather.hpp"
#include "kernels/specification/built_energy.hpp"

#include <cstdint>

namespace hdmbench::energies::HDMBENCH_ENERGY {

std::int64_t scalar_sweep(const Level& level, int number, const VectorField& from, VectorField& to);

namespace {

using InFloat = ::hdmbench::HDMBENCH_ENERGY<float>;

/// Rule and colours are constants, as update.inc wants them.
template <int rule, int colours>
std::int64_t sweep(const Level& level, int number, const VectorField& from, VectorField& to) {
  const SweepState state = sweep_state(level, number);
  const InFloat::Sweep turn{state.colour, state.strength, state.number, state.seed};
  const float* steps = level.steps.padded().data();
  const int step_count = level.steps.count();
  std::int64_t changed = 0;
  for (int y = 0; y < level.extent.height; ++y) {
    for (int x = 0; x < level.extent.width; ++x) {
      const InFloat::Site site = gather<InFloat>(level, from, x, y);
      const InFloat::Position at{static_cast<float>(x), static_cast<float>(y)};
      const InFloat::Displacement next =
          InFloat::swept_displacement(rule, colours, true, site, at, turn, steps, step_count);
      changed += (next.x != site.dx.centre || next.y != site.dy.centre) ? 1 : 0;
      const std::size_t index = level.extent.index(x, y);
      to[0][index] = next.x;
      to[1][index] = next.y;
    }
  }
  return changed;
}

template <int rule>
std::int64_t sweep_by_colours(const Level& level, int number, const VectorField& from, VectorField& to) {
  switch (sweeps_per_iteration(level)) {
  case 2:
    return sweep<rule, 2>(level, number, from, to);
  case 4:
    return sweep<rule, 4>(level, number, from, to);
  default:
    return sweep<rule, 1>(level, number, from, to);
  }
}

} // namespace

std::int64_t scalar_sweep(const Level& level, int number, const VectorField& from, VectorField& to) {
  switch (level.rule) {
  case Rule::closed_form:
    return sweep_by_colours<InFloat::rule_closed_form>(level, number, from, to);
  case Rule::annealing:
    return sweep_by_colours<InFloat::rule_annealing>(level, number, from, to);
  default:
    return sweep_by_colours<InFloat::rule_steps>(level, number, from, to);
  }
}

} // namespace hdmbench::energies::HDMBENCH_ENERGY
