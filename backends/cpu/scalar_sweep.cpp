// Built once per energy (built_energy.hpp), with plain -O2: the specification read aloud, one site after the
// other.

#include "kernels/data/gather.hpp"
#include "kernels/specification/built_energy.hpp"

#include <cstdint>

namespace hdmbench::energies::HDMBENCH_ENERGY {

std::int64_t scalar_sweep(const Level& level, int number, const VectorField& from, VectorField& to);

namespace {

/// Axes, rule and colours are constants, as update.inc wants them.
template <typename InFloat, int rule, int colours>
std::int64_t sweep_sites(const Level& level, int number, const VectorField& from, VectorField& to) {
  const SweepState state = sweep_state(level, number);
  const typename InFloat::Sweep turn{state.colour, state.strength, state.number, state.seed};
  const float* steps = level.steps.padded().data();
  const int step_count = level.steps.count();
  std::int64_t changed = 0;
  for (int row = 0; row < level.extent.rows(); ++row) {
    const int y = row % level.extent.height;
    const int z = row / level.extent.height;
    for (int x = 0; x < level.extent.width; ++x) {
      const typename InFloat::Site site = gather<InFloat>(level, from, x, y, z);
      const typename InFloat::Displacement next = InFloat::swept_displacement(
          rule, colours, true, site, InFloat::position_of(x, y, z), turn, steps, step_count);
      const std::size_t index = level.extent.index(x, y, z);
      bool moved = false;
      language::for_each_axis<InFloat::axes>([&]<int axis>() HDM_INLINED {
        constexpr auto of = InFloat::of_axis[axis];
        moved = moved || next.*of.moved != (site.*of.displacement).centre;
        to[axis][index] = next.*of.moved;
      });
      changed += moved ? 1 : 0;
    }
  }
  return changed;
}

template <int rule, int colours>
std::int64_t sweep(const Level& level, int number, const VectorField& from, VectorField& to) {
  return level.extent.axes() > 2
             ? sweep_sites<::hdmbench::HDMBENCH_ENERGY<float, 3>, rule, colours>(level, number, from, to)
             : sweep_sites<::hdmbench::HDMBENCH_ENERGY<float>, rule, colours>(level, number, from, to);
}

template <int rule>
std::int64_t sweep_by_colours(const Level& level, int number, const VectorField& from, VectorField& to) {
  switch (sweeps_per_iteration(level)) {
  case 2:
    return sweep<rule, 2>(level, number, from, to);
  case 4:
    return sweep<rule, 4>(level, number, from, to);
  case 8:
    return sweep<rule, 8>(level, number, from, to);
  default:
    return sweep<rule, 1>(level, number, from, to);
  }
}

using Rules = ::hdmbench::HDMBENCH_ENERGY<float>;

} // namespace

std::int64_t scalar_sweep(const Level& level, int number, const VectorField& from, VectorField& to) {
  switch (level.rule) {
  case Rule::closed_form:
    return sweep_by_colours<Rules::rule_closed_form>(level, number, from, to);
  case Rule::annealing:
    return sweep_by_colours<Rules::rule_annealing>(level, number, from, to);
  default:
    return sweep_by_colours<Rules::rule_steps>(level, number, from, to);
  }
}

} // namespace hdmbench::energies::HDMBENCH_ENERGY
