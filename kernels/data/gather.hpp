#pragma once

#include "kernels/data/level.hpp"
#include "kernels/specification/hdm/energy.hpp"

#include <algorithm>
#include <vector>

namespace hdmbench {

/// What one site sees of `displacement` on `level`, as gather.glsl has it in shaders: a neighbour outside the
/// image has the displacement and the modulus of the centre (thesis 6.2.6). `Arithmetic` is an energy with
/// its scalar, as Hdm<float>; `inverse` makes its 1 / m from the level's.
template <typename Arithmetic, typename Inverse>
[[gnu::always_inline]] inline typename Arithmetic::Site
gather(const Level& level, const VectorField& displacement, int x, int y, const Inverse& inverse) {
  using real = typename Arithmetic::real;
  using Neighbours = typename Arithmetic::Neighbours;
  const Extent extent = level.extent;
  const std::size_t at = extent.index(x, y);
  const auto neighbour = [&](int dx, int dy) {
    const int nx = x + dx;
    const int ny = y + dy;
    const bool inside = nx >= 0 && ny >= 0 && nx < extent.width && ny < extent.height;
    return inside ? extent.index(nx, ny) : at;
  };
  const std::size_t north_west = neighbour(-1, -1);
  const std::size_t north = neighbour(0, -1);
  const std::size_t north_east = neighbour(1, -1);
  const std::size_t west = neighbour(-1, 0);
  const std::size_t east = neighbour(1, 0);
  const std::size_t south_west = neighbour(-1, 1);
  const std::size_t south = neighbour(0, 1);
  const std::size_t south_east = neighbour(1, 1);
  const auto same = [](float value) { return real(value); };
  const auto pick = [&](const std::vector<float>& values, const auto& each) {
    return Neighbours{each(values[north_west]), each(values[north]), each(values[north_east]),
                      each(values[west]),       each(values[at]),    each(values[east]),
                      each(values[south_west]), each(values[south]), each(values[south_east])};
  };
  const bool curvature_known = !level.inverse_curvature[0].empty() && needs_inverse_curvature(level.rule);
  typename Arithmetic::Site site; // every member is set below
  site.dx = pick(displacement[0], same);
  site.dy = pick(displacement[1], same);
  site.inverse_modulus = pick(level.inverse_modulus.values, inverse);
  site.modulus = level.modulus.values[at];
  site.target_x = level.target[0][at];
  site.target_y = level.target[1][at];
  site.confidence_x = level.confidence[0][at];
  site.confidence_y = level.confidence[1][at];
  site.penalty = level.penalty;
  site.inverse_curvature_x = curvature_known ? level.inverse_curvature[0][at] : 0.0F;
  site.inverse_curvature_y = curvature_known ? level.inverse_curvature[1][at] : 0.0F;
  Arithmetic::set_inputs(
      site, [&](int number) { return pick(level.inputs[static_cast<std::size_t>(number)].values, same); });
  return site;
}

template <typename Arithmetic>
[[gnu::always_inline]] inline typename Arithmetic::Site
gather(const Level& level, const VectorField& displacement, int x, int y) {
  return gather<Arithmetic>(level, displacement, x, y,
                            [](float value) { return typename Arithmetic::real(value); });
}

/// The site after sweep `number` of the level, sequential ones apart.
template <typename Arithmetic>
typename Arithmetic::Displacement swept_site(const Level& level, const VectorField& displacement, int number,
                                             int x, int y) {
  using real = typename Arithmetic::real;
  const SweepState state = sweep_state(level, number);
  const typename Arithmetic::Sweep turn{state.colour, state.strength, state.number, state.seed};
  real steps[StepSet::maximum_count];
  std::copy_n(level.steps.padded().begin(), StepSet::maximum_count, steps);
  return Arithmetic::swept_displacement(static_cast<int>(level.rule), sweeps_per_iteration(level), true,
                                        gather<Arithmetic>(level, displacement, x, y),
                                        {static_cast<float>(x), static_cast<float>(y)}, turn, steps,
                                        level.steps.count());
}

} // namespace hdmbench
