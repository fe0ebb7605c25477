#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/interpolation.hpp"
#include "test/random_level.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace hdmbench {
namespace {

/// Targets everywhere; `is_observed` says where they count.
Level level_of(Extent extent, const std::function<float(int, int)>& target,
               const std::function<bool(int, int)>& is_observed) {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent, 1.0F),
              .inverse_modulus = {}};
  set_inverse_modulus(level);
  for_each_site(extent, [&](int x, int y) {
    const auto i = extent.index(x, y);
    level.target.x[i] = target(x, y);
    level.target.y[i] = -target(x, y);
    level.confidence.x[i] = level.confidence.y[i] = is_observed(x, y) ? 0.5F : 0.0F;
  });
  return level;
}

float linear(int x, int y) {
  return 2.0F + 0.5F * static_cast<float>(x) - 0.25F * static_cast<float>(y);
}

TEST(Interpolation, LinearFieldsAreMet) {
  const Extent extent{11, 8};
  const auto on_border = [&](int x, int y) {
    return x == 0 || y == 0 || x + 1 == extent.width || y + 1 == extent.height;
  };
  const auto on_ellipse_or_border = [&](int x, int y) { return on_border(x, y) || (x + y) % 5 == 0; };
  const auto at_sides = [&](int x, int) { return x == 0 || x + 1 == extent.width; };
  for (const std::function<bool(int, int)>& where :
       std::initializer_list<std::function<bool(int, int)>>{on_border, on_ellipse_or_border, at_sides}) {
    const ReferenceField field = interpolate_conditions(level_of(extent, linear, where));
    for_each_site(extent, [&](int x, int y) {
      EXPECT_NEAR(field.x[extent.index(x, y)], static_cast<double>(linear(x, y)), 1e-14);
      EXPECT_NEAR(field.y[extent.index(x, y)], -static_cast<double>(linear(x, y)), 1e-14);
    });
  }
}

TEST(Interpolation, RowAndColumnAreBlendedByTheDistanceToTheirNearerEnds) {
  // Row 2 has 10 at both ends, 1 and 4 sites away; column 1 has 40 at both ends, 2 sites away.
  const auto where = [](int x, int y) {
    return (y == 2 && (x == 0 || x == 5)) || (x == 1 && (y == 0 || y == 4));
  };
  const Level level = level_of(
      {6, 5}, [](int x, int) { return x == 1 ? 40.0F : 10.0F; }, where);
  const ReferenceField field = interpolate_conditions(level);
  EXPECT_NEAR(field.x[level.extent.index(1, 2)], (10.0 / 1.0 + 40.0 / 2.0) / (1.0 / 1.0 + 1.0 / 2.0), 1e-13);
}

} // namespace
} // namespace hdmbench
