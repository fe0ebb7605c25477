#pragma once

#include "kernels/data/level.hpp"
#include "kernels/specification/hdm/energy.hpp"

#include <algorithm>
#include <vector>

namespace hdmbench {

/// What one site sees of `displacement` on `level`, as gather.glsl has it in shaders: a neighbour outside the
/// image has the displacement and the modulus of the centre (thesis 6.2.6). `Arithmetic` is an energy with
/// its scalar and as many axes as the level, as Hdm<float>; `inverse` makes its 1 / m from the level's.
template <typename Arithmetic, typename Inverse>
[[gnu::always_inline]] inline typename Arithmetic::Site
gather(const Level& level, const VectorField& displacement, int x, int y, int z, const Inverse& inverse) {
  using real = typename Arithmetic::real;
  const Extent extent = level.extent;
  const std::size_t at = extent.index(x, y, z);
  const auto seen = Arithmetic::indices_of([&](int number) HDM_INLINED {
    const auto [dx, dy, dz] = language::direction_of(number);
    const int nx = x + dx;
    const int ny = y + dy;
    const int nz = z + dz;
    const bool inside = nx >= 0 && ny >= 0 && nx < extent.width && ny < extent.height &&
                        (dz == 0 || (nz >= 0 && nz < extent.depth));
    return inside ? extent.index(nx, ny, nz) : at;
  });
  const auto same = [](float value) { return real(value); };
  const auto pick = [&](const std::vector<float>& values, const auto& each) {
    return Arithmetic::neighbours_of([&](int number)
                                         HDM_INLINED { return each(values[seen.values[number]]); });
  };
  const bool curvature_known = !level.inverse_curvature[0].empty() && needs_inverse_curvature(level.rule);
  typename Arithmetic::Site site; // every member is set below
  language::for_each_axis<Arithmetic::axes>([&]<int axis>() HDM_INLINED {
    constexpr auto of = Arithmetic::of_axis[axis];
    site.*of.displacement = pick(displacement[axis], same);
    site.*of.target = level.target[axis][at];
    site.*of.confidence = level.confidence[axis][at];
    site.*of.inverse_curvature = curvature_known ? level.inverse_curvature[axis][at] : 0.0F;
  });
  site.inverse_modulus = pick(level.inverse_modulus.values, inverse);
  site.modulus = level.modulus.values[at];
  site.penalty = level.penalty;
  Arithmetic::set_inputs(
      site, [&](int number) { return pick(level.inputs[static_cast<std::size_t>(number)].values, same); });
  return site;
}

template <typename Arithmetic>
[[gnu::always_inline]] inline typename Arithmetic::Site
gather(const Level& level, const VectorField& displacement, int x, int y, int z = 0) {
  return gather<Arithmetic>(level, displacement, x, y, z,
                            [](float value) { return typename Arithmetic::real(value); });
}

/// The site after sweep `number` of the level, sequential ones apart.
template <typename Arithmetic>
typename Arithmetic::Displacement swept_site(const Level& level, const VectorField& displacement, int number,
                                             int x, int y, int z = 0) {
  using real = typename Arithmetic::real;
  const SweepState state = sweep_state(level, number);
  const typename Arithmetic::Sweep turn{state.colour, state.strength, state.number, state.seed};
  real steps[StepSet::maximum_count];
  std::copy_n(level.steps.padded().begin(), StepSet::maximum_count, steps);
  return Arithmetic::swept_displacement(static_cast<int>(level.rule), sweeps_per_iteration(level), true,
                                        gather<Arithmetic>(level, displacement, x, y, z),
                                        Arithmetic::position_of(x, y, z), turn, steps, level.steps.count());
}

} // namespace hdmbench
