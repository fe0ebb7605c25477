// Levels of the pyramid, and the reference's iteration and prolongation that judge the kernels'.

#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/pyramid.hpp"
#include "reference/thesis_energy.hpp"
#include "test/random_level.hpp"
#include "test/sessions.hpp"
#include "test/suite.hpp"

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
    EXPECT_EQ(pyramid_extents(full).front(), full);
    EXPECT_EQ(pyramid_extents(full).back(), (Extent{1, 1}));
  }
  EXPECT_EQ(pyramid_extents({257, 130}).at(1), (Extent{256, 128}));
  EXPECT_THROW((void)pyramid_extents({0, 5}), InputError);
}

TEST(Pyramid, AVolumeEndsInEightSites) {
  EXPECT_EQ(pyramid_extents({33, 7, 2}),
            (std::vector<Extent>{{33, 7, 2}, {32, 4, 2}, {16, 2, 2}, {8, 2, 2}, {4, 2, 2}, {2, 2, 2}}));
  EXPECT_THROW((void)pyramid_extents({1, 5, 5}), InputError);
}

TEST(Pyramid, AVolumeIsProlongatedAndSampledAlongThreeAxes) {
  const Extent fine{33, 7, 15};
  const Extent coarse = pyramid_extents(fine).at(1);
  const auto affine = [](Extent of, int x, int y, int z) {
    return 3.0F + 8.0F * static_cast<float>(x) / static_cast<float>(of.width - 1) -
           4.0F * static_cast<float>(y) / static_cast<float>(of.height - 1) +
           2.0F * static_cast<float>(z) / static_cast<float>(of.depth - 1);
  };
  const auto fill = [&](VectorField& field) {
    for (int z = 0; z < field.extent.depth; ++z) {
      for_each_site(Extent{field.extent.width, field.extent.height}, [&](int x, int y) {
        field[2][field.extent.index(x, y, z)] = affine(field.extent, x, y, z);
      });
    }
  };
  VectorField field(coarse);
  VectorField expected(fine);
  fill(field);
  fill(expected);
  const VectorField result = prolongate(field, fine, Alignment::corner);
  for (std::size_t i = 0; i < fine.sites(); ++i) {
    ASSERT_NEAR(result[2][i], expected[2][i], 5e-6F);
  }
  EXPECT_EQ(result[0], std::vector<float>(fine.sites()));
  const VectorField sampled = sample_field(expected, coarse, Alignment::corner);
  EXPECT_EQ(sampled[2][coarse.index(5, 2, 6)], affine(fine, 5, 4, 12));
}

TEST(Pyramid, ProlongationKeepsAffineFieldsAndCorners) {
  for (const Extent fine : {Extent{300, 300}, Extent{257, 130}, Extent{8, 8}, Extent{1, 7}}) {
    const Extent coarse = pyramid_extents(fine).at(1);
    VectorField field(coarse);
    const auto fraction = [](int i, int n) {
      return n > 1 ? static_cast<float>(i) / static_cast<float>(n - 1) : 0.0F;
    };
    for_each_site(coarse, [&](int x, int y) {
      field[0][coarse.index(x, y)] =
          3.0F + 8.0F * fraction(x, coarse.width) - 4.0F * fraction(y, coarse.height);
      field[1][coarse.index(x, y)] = -field[0][coarse.index(x, y)];
    });
    const VectorField result = prolongate(field, fine, Alignment::corner);
    for_each_site(fine, [&](int x, int y) {
      const float expected = 3.0F + 8.0F * fraction(x, fine.width) - 4.0F * fraction(y, fine.height);
      EXPECT_NEAR(result[0][fine.index(x, y)], expected, 5e-6F);
      EXPECT_NEAR(result[1][fine.index(x, y)], -expected, 5e-6F);
    });
    EXPECT_EQ(result[0].front(), field[0].front());
    EXPECT_EQ(result[0].back(), field[0].back());
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
    EXPECT_EQ(level.target[0][to], problem.level.target[0][from]);
    EXPECT_EQ(level.confidence[1][to], problem.level.confidence[1][from]);
  });
}

/// Every operation is exact on dyadic levels, so a tie is a tie in any order of summation.
TEST(ThesisIcm, EverySiteTakesTheFirstBestCandidateOfTheThesisEnergy) {
  int tied = 0;
  for (const Extent extent :
       {Extent{29, 31}, {1, 1}, {1, 7}, {6, 1}, {2, 2}, {5, 7, 3}, {2, 2, 2}, {9, 6, 8}}) {
    const auto problem = test::random_problem(extent, test::Texture::dyadic, 6);
    const VectorField next = test::swept(problem, 1);
    const ThesisEnergy energy(problem.level, problem.start);
    for_each_site(extent, [&](int x, int y, int z) {
      const std::size_t site = extent.index(x, y, z);
      std::array<double, 3> lowest{};
      lowest.fill(std::numeric_limits<double>::infinity());
      std::array<double, 3> best{};
      for (const float step : problem.level.steps.values()) {
        std::array<double, 3> to{};
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          to[axis] = static_cast<double>(problem.start[axis][site]) + static_cast<double>(step);
        }
        const auto found = energy.at(x, y, {to[0], to[1], to[2]}, z);
        const std::array<double, 3> of{found.x, found.y, found.z};
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          tied += of[axis] == lowest[axis] ? 1 : 0;
          best[axis] = of[axis] < lowest[axis] ? to[axis] : best[axis];
          lowest[axis] = std::min(of[axis], lowest[axis]);
        }
      }
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        ASSERT_EQ(next[axis][site], best[axis]) << "axis " << axis << " at " << extent.place(site);
      }
    });
  }
  EXPECT_GT(tied, 0) << "no two candidates ever tied";
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
