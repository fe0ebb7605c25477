#include "harness/scene/sites.hpp"
#include "kernels/data/pyramid.hpp"

#include "kernels/data/input_error.hpp"
#include "test/random_level.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {
namespace {

TEST(Pyramid, SizesAreThoseOfTheThesis) {
  std::vector<int> widths;
  for (const Extent extent : pyramid_extents({300, 300})) {
    widths.push_back(extent.width);
  }
  EXPECT_EQ(widths, (std::vector<int>{300, 256, 128, 64, 32, 16, 8, 4, 2, 1}));
}

TEST(Pyramid, EveryExtentEndsInOneSite) {
  for (const Extent full : {Extent{1, 1}, Extent{1, 7}, Extent{5, 1}, Extent{256, 256}, Extent{257, 130}}) {
    const auto extents = pyramid_extents(full);
    EXPECT_EQ(extents.front(), full);
    EXPECT_EQ(extents.back(), (Extent{1, 1}));
  }
  EXPECT_EQ(pyramid_extents({257, 130}).at(1), (Extent{256, 128}));
  EXPECT_THROW((void)pyramid_extents({0, 5}), InputError);
}

TEST(Pyramid, ProlongationKeepsAffineFieldsAndCorners) {
  for (const Extent fine : {Extent{300, 300}, Extent{257, 130}, Extent{8, 8}, Extent{1, 7}}) {
    const Extent coarse = pyramid_extents(fine).at(1);
    VectorField field(coarse);
    const auto fraction = [](int i, int n) {
      return n > 1 ? static_cast<float>(i) / static_cast<float>(n - 1) : 0.0F;
    };
    for_each_site(coarse, [&](int x, int y) {
      field.x[coarse.index(x, y)] =
          3.0F + 8.0F * fraction(x, coarse.width) - 4.0F * fraction(y, coarse.height);
      field.y[coarse.index(x, y)] = -field.x[coarse.index(x, y)];
    });
    const VectorField result = prolongate(field, fine, Alignment::corner);
    for_each_site(fine, [&](int x, int y) {
      const float expected = 3.0F + 8.0F * fraction(x, fine.width) - 4.0F * fraction(y, fine.height);
      EXPECT_NEAR(result.x[fine.index(x, y)], expected, 5e-6F);
      EXPECT_NEAR(result.y[fine.index(x, y)], -expected, 5e-6F);
    });
    EXPECT_EQ(result.x.front(), field.x.front());
    EXPECT_EQ(result.x.back(), field.x.back());
  }
}

TEST(Pyramid, LevelsSampleTheFullImage) {
  const auto problem = test::random_problem({37, 23}, test::Texture::smooth, 2);
  const Extent extent{16, 16};
  const Level level = sample_level(problem.level, extent, Alignment::corner);
  for_each_site(extent, [&](int x, int y) {
    const auto from = problem.level.extent.index(sampled_index(x, 16, 37, Alignment::corner),
                                                 sampled_index(y, 16, 23, Alignment::corner));
    const auto to = extent.index(x, y);
    EXPECT_EQ(level.modulus.values[to], problem.level.modulus.values[from]);
    EXPECT_EQ(level.inverse_modulus.values[to], problem.level.inverse_modulus.values[from]);
    EXPECT_EQ(level.target.x[to], problem.level.target.x[from]);
    EXPECT_EQ(level.confidence.y[to], problem.level.confidence.y[from]);
  });
}

} // namespace
} // namespace hdmbench
