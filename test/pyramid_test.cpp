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

TEST(Pyramid, CornersMeetOnEveryLevel) {
  for (int fine = 1; fine <= 70; ++fine) {
    for (int coarse = 2; coarse <= fine; ++coarse) {
      EXPECT_EQ(sampled_index(0, coarse, fine, Alignment::corner), 0);
      EXPECT_EQ(sampled_index(coarse - 1, coarse, fine, Alignment::corner), fine - 1);
    }
    EXPECT_EQ(sampled_index(0, 1, fine, Alignment::corner), fine / 2);
  }
}

TEST(Pyramid, CornerSamplesAreTheNearest) {
  for (int coarse = 2; coarse <= 16; ++coarse) {
    for (int i = 0; i < coarse; ++i) {
      const double position = i * 299.0 / (coarse - 1);
      EXPECT_LE(std::abs(sampled_index(i, coarse, 300, Alignment::corner) - position), 0.5);
    }
  }
}

TEST(Pyramid, CenterAlignmentLosesABorderOnePixelWide) {
  const auto problem = test::random_problem({300, 300}, test::Texture::smooth, 1);
  Level level = problem.level;
  level.confidence = VectorField(level.extent);
  for (int y = 0; y < 300; ++y) {
    level.confidence.x[level.extent.index(0, y)] = 1.0F;
  }
  const auto observed = [&](Alignment alignment) {
    const Level coarse = sample_level(level, {64, 64}, alignment);
    return std::ranges::count(coarse.confidence.x, 1.0F);
  };
  EXPECT_EQ(observed(Alignment::corner), 64);
  EXPECT_EQ(observed(Alignment::center), 0);
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

TEST(Pyramid, MeanModuliAreThoseOfTheSitesACoarseOneStandsFor) {
  for (const auto& [full, coarse] :
       {std::pair{Extent{30, 7}, Extent{8, 4}}, std::pair{Extent{16, 9}, Extent{8, 9}},
        std::pair{Extent{9, 5}, Extent{2, 1}}, std::pair{Extent{1, 12}, Extent{1, 8}}}) {
    const Level level = test::random_problem(full, test::Texture::smooth, 6).level;
    for (const Alignment alignment : {Alignment::corner, Alignment::center}) {
      const Level mean = sample_level(level, coarse, alignment, Material::mean);
      const auto belongs = [&](int i, int k, int j, int n) {
        if (alignment == Alignment::center || k == 1) {
          return k == 1 || (2 * j + 1) * k / (2 * n) == i;
        }
        return std::abs(2 * j * (k - 1) - 2 * i * (n - 1)) <= n - 1;
      };
      for (int y = 0; y < coarse.height; ++y) {
        for (int x = 0; x < coarse.width; ++x) {
          double sum = 0.0;
          int sites = 0;
          for (int v = 0; v < full.height; ++v) {
            for (int u = 0; u < full.width; ++u) {
              if (belongs(x, coarse.width, u, full.width) && belongs(y, coarse.height, v, full.height)) {
                sum += static_cast<double>(level.modulus.values[full.index(u, v)]);
                ++sites;
              }
            }
          }
          const float modulus = mean.modulus.values[coarse.index(x, y)];
          EXPECT_FLOAT_EQ(modulus, static_cast<float>(sum / sites)) << coarse.width << ": " << x << ", " << y;
          EXPECT_EQ(mean.inverse_modulus.values[coarse.index(x, y)], 1.0F / modulus);
        }
      }
      const Level nearest = sample_level(level, coarse, alignment);
      EXPECT_EQ(mean.target.x, nearest.target.x);
      EXPECT_EQ(mean.confidence.y, nearest.confidence.y);
      EXPECT_EQ(sample_level(level, full, alignment, Material::mean).modulus.values, level.modulus.values);
    }
  }
}

} // namespace
} // namespace hdmbench
