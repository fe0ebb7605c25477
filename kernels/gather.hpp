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

} // namespace hdmbench::energy
