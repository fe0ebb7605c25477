#pragma once

#include "harness/scene/sites.hpp"
#include "reference/finite_elements.hpp"

#include <functional>

/// Sheets of finite elements.
namespace hdmbench::test {

struct Vector {
  double x = 0.0;
  double y = 0.0;
};
using Displacement = std::function<Vector(double x, double y)>;

inline ReferenceField sampled(Extent extent, const Displacement& displacement) {
  ReferenceField field(extent);
  for_each_site(extent, [&](int x, int y) {
    const Vector value = displacement(x, y);
    field[0][extent.index(x, y)] = value.x;
    field[1][extent.index(x, y)] = value.y;
  });
  return field;
}

/// The whole border prescribed.
inline ElasticProblem clamped_sheet(Extent extent, const Displacement& displacement, double modulus = 1.0) {
  ElasticProblem problem{.extent = extent,
                         .modulus = std::vector<double>(extent.sites(), modulus),
                         .fixed_x = std::vector<std::uint8_t>(extent.sites()),
                         .fixed_y = {},
                         .prescribed = sampled(extent, displacement),
                         .force = {}};
  for_each_site(extent, [&](int x, int y) {
    const bool border = x == 0 || y == 0 || x + 1 == extent.width || y + 1 == extent.height;
    problem.fixed_x[extent.index(x, y)] = border ? 1 : 0;
  });
  problem.fixed_y = problem.fixed_x;
  return problem;
}

} // namespace hdmbench::test
