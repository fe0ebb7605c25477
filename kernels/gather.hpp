#pragma once

#include "kernels/energy.hpp"
#include "kernels/level.hpp"

#include <vector>

namespace hdmbench::energy {

/// What one site sees of `displacement` on `level`: gather.glsl in C++. A neighbour outside the image has the
/// displacement and the modulus of the centre (thesis 6.2.6).
HDM_FUNCTION Site gather(const Level& level, const VectorField& displacement, int x, int y) {
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
  const bool curvature_known = !level.inverse_curvature.x.empty();
  const auto pick = [&](const std::vector<float>& values) {
    return Neighbours{values[north_west], values[north], values[north_east],
                      values[west],       values[at],    values[east],
                      values[south_west], values[south], values[south_east]};
  };
  return {.dx = pick(displacement.x),
          .dy = pick(displacement.y),
          .inverse_modulus = pick(level.inverse_modulus.values),
          .modulus = level.modulus.values[at],
          .target_x = level.target.x[at],
          .target_y = level.target.y[at],
          .confidence_x = level.confidence.x[at],
          .confidence_y = level.confidence.y[at],
          .penalty = level.penalty,
          .inverse_curvature_x = curvature_known ? level.inverse_curvature.x[at] : 0.0F,
          .inverse_curvature_y = curvature_known ? level.inverse_curvature.y[at] : 0.0F};
}

/// The same site for energy.inc compiled with another scalar: `Other` is the Site of that, whose scalar takes
/// floats. `inverse` gives its 1 / m from ours.
template <typename Other, typename Inverse>
Other converted(const Site& from, const Inverse& inverse) {
  const auto neighbours = [](const Neighbours& of, const auto& each) {
    return decltype(Other::dx){each(of.north_west), each(of.north),  each(of.north_east),
                               each(of.west),       each(of.centre), each(of.east),
                               each(of.south_west), each(of.south),  each(of.south_east)};
  };
  const auto same = [](float value) { return value; };
  return {neighbours(from.dx, same),
          neighbours(from.dy, same),
          neighbours(from.inverse_modulus, inverse),
          from.modulus,
          from.target_x,
          from.target_y,
          from.confidence_x,
          from.confidence_y,
          from.penalty,
          from.inverse_curvature_x,
          from.inverse_curvature_y};
}
template <typename Other>
Other converted(const Site& from) {
  return converted<Other>(from, [](float value) { return value; });
}

} // namespace hdmbench::energy
