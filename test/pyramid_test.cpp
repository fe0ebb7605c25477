// Levels of the pyramid, and the reference's prolongation that judges the kernels'.

#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/pyramid.hpp"
#include "reference/thesis_energy.hpp"
#include "test/random_level.hpp"
#include "test/suite.hpp"

namespace hdmbench {
namespace {

TEST(Pyramid, EveryExtentEndsInOneSiteAndThatOfAVolumeInEight) {
  const std::vector<Extent> square{{300, 300}, {256, 256}, {128, 128}, {64, 64}, {32, 32},
                                   {16, 16},   {8, 8},     {4, 4},     {2, 2},   {1, 1}};
  EXPECT_EQ(pyramid_extents({300, 300}), square) << "the thesis's";
  for (const Extent full : {Extent{1, 1}, {1, 7}, {5, 1}, {256, 256}, {257, 130}}) {
    EXPECT_EQ(pyramid_extents(full).front(), full);
    EXPECT_EQ(pyramid_extents(full).back(), (Extent{1, 1}));
  }
  EXPECT_EQ(pyramid_extents({257, 130}).at(1), (Extent{256, 128}));
  EXPECT_EQ(pyramid_extents({33, 7, 2}),
            (std::vector<Extent>{{33, 7, 2}, {32, 4, 2}, {16, 2, 2}, {8, 2, 2}, {4, 2, 2}, {2, 2, 2}}));
  EXPECT_THROW((void)pyramid_extents({0, 5}), InputError);
  EXPECT_THROW((void)pyramid_extents({1, 5, 5}), InputError);
}

/// Each component is another one, linear along every axis.
VectorField affine_field(Extent extent) {
  const auto share = [](int i, int n) {
    return n > 1 ? static_cast<float>(i) / static_cast<float>(n - 1) : 0.0F;
  };
  VectorField field(extent);
  for_each_site(extent, [&](int x, int y, int z) {
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      field[axis][extent.index(x, y, z)] = 3.0F - static_cast<float>(axis) + 8.0F * share(x, extent.width) -
                                           4.0F * share(y, extent.height) + 2.0F * share(z, extent.depth);
    }
  });
  return field;
}

TEST(Pyramid, ProlongationKeepsAffineFieldsAndCorners) {
  for (const Extent fine : {Extent{300, 300}, {257, 130}, {8, 8}, {1, 7}, {33, 7, 15}}) {
    const VectorField field = affine_field(pyramid_extents(fine).at(1));
    const VectorField expected = affine_field(fine);
    const VectorField result = prolongate(field, fine, Alignment::corner);
    for (std::size_t axis = 0; axis < fine.axes(); ++axis) {
      for (std::size_t i = 0; i < fine.sites(); ++i) {
        ASSERT_NEAR(result[axis][i], expected[axis][i], 5e-6F) << fine.text() << ", axis " << axis;
      }
      EXPECT_EQ(result[axis].front(), field[axis].front());
      EXPECT_EQ(result[axis].back(), field[axis].back());
    }
  }
}

TEST(Pyramid, LevelsSampleTheFullImage) {
  for (const auto& [full, extent] : {std::pair{Extent{37, 23}, Extent{16, 16}}, {{33, 7, 15}, {32, 4, 8}}}) {
    const auto problem = test::random_problem(full, test::Texture::smooth, 2);
    const Level level = sample_level(problem.level, extent, Alignment::corner);
    const VectorField start = sample_field(problem.start, extent, Alignment::corner);
    for_each_site(extent, [&, &full = full, &extent = extent](int x, int y, int z) {
      const auto at = [](int i, int coarse, int fine) {
        return sampled_index(i, coarse, fine, Alignment::corner);
      };
      const auto from = full.index(at(x, extent.width, full.width), at(y, extent.height, full.height),
                                   at(z, extent.depth, full.depth));
      const auto to = extent.index(x, y, z);
      EXPECT_EQ(level.modulus.values[to], problem.level.modulus.values[from]);
      EXPECT_EQ(level.inverse_modulus.values[to], problem.level.inverse_modulus.values[from]);
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        EXPECT_EQ(level.target[axis][to], problem.level.target[axis][from]);
        EXPECT_EQ(level.confidence[axis][to], problem.level.confidence[axis][from]);
        EXPECT_EQ(start[axis][to], problem.start[axis][from]);
      }
    });
  }
}

TEST(ThesisProlongation, IsThatOfTheKernelsToFloatRounding) {
  for (const Extent fine :
       {Extent{300, 100}, Extent{257, 130}, Extent{8, 8}, Extent{1, 7}, Extent{5, 1}, Extent{9, 20, 13}}) {
    const Extent coarse = pyramid_extents(fine).at(1);
    const VectorField field = test::random_problem(coarse, test::Texture::smooth, 9).start;
    const VectorField kernels = prolongate(field, fine, Alignment::corner);
    const ReferenceField thesis = thesis_prolongation(ReferenceField(field), fine);
    // Values up to 10, weights rounded to float once, six operations.
    const double tolerance = 10.0 * 8.0 * static_cast<double>(std::numeric_limits<float>::epsilon());
    for (std::size_t axis = 0; axis < fine.axes(); ++axis) {
      for (std::size_t i = 0; i < fine.sites(); ++i) {
        ASSERT_NEAR(thesis[axis][i], static_cast<double>(kernels[axis][i]), tolerance);
      }
    }
  }
}

} // namespace
} // namespace hdmbench
