#include "harness/scene/sites.hpp"
#include "reference/thesis_energy.hpp"
#include "reference/thesis_icm.hpp"
#include "test/random_level.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace hdmbench {
namespace {

/// Every operation is exact on dyadic levels, so a tie is a tie in any order of summation.
TEST(ThesisIcm, EverySiteTakesTheFirstBestCandidateOfTheThesisEnergy) {
  int tied = 0;
  for (const Extent extent : {Extent{29, 31}, {1, 1}, {1, 7}, {6, 1}, {2, 2}}) {
    const auto [level, start] =
        test::random_problem(extent, test::Texture::dyadic, 6, StepSet::parse("0,-1,1,-0.25,0.25,-0.5,0.5"));
    ReferenceField field(start);
    for (int iteration = 0; iteration < 20; ++iteration) {
      const ReferenceField next = thesis_iteration(level, field);
      using Energy = ThesisEnergyOf<ReferenceField>;
      const Energy energy(level, field);
      for_each_site(extent, [&, &level = level](int x, int y) {
        const auto i = extent.index(x, y);
        Energy::Value lowest{1e300, 1e300};
        Energy::Value best{};
        for (const float step : level.steps.values()) {
          const Energy::Value to{field.x[i] + double{step}, field.y[i] + double{step}};
          const auto found = energy.at(x, y, to);
          tied += found.x == lowest.x ? 1 : 0;
          best.x = found.x < lowest.x ? to.x : best.x;
          best.y = found.y < lowest.y ? to.y : best.y;
          lowest = {std::min(found.x, lowest.x), std::min(found.y, lowest.y)};
        }
        ASSERT_EQ(next.x[i], best.x) << x << ", " << y << ", iteration " << iteration;
        ASSERT_EQ(next.y[i], best.y) << x << ", " << y << ", iteration " << iteration;
      });
      field = next;
    }
  }
  EXPECT_GT(tied, 0) << "no two candidates ever tied";
}

TEST(ThesisProlongation, IsThatOfTheKernelsToFloatRounding) {
  for (const Alignment alignment : {Alignment::corner, Alignment::center}) {
    for (const Extent fine : {Extent{300, 100}, Extent{257, 130}, Extent{8, 8}, Extent{1, 7}, Extent{5, 1}}) {
      const Extent coarse = pyramid_extents(fine).at(1);
      const VectorField field = test::random_problem(coarse, test::Texture::smooth, 9).start;
      const VectorField kernels = prolongate(field, fine, alignment);
      const ReferenceField thesis = thesis_prolongation(ReferenceField(field), fine, alignment);
      // Values up to 10, weights rounded to float once, six operations.
      const double tolerance = 10.0 * 8.0 * static_cast<double>(std::numeric_limits<float>::epsilon());
      for (std::size_t i = 0; i < fine.sites(); ++i) {
        ASSERT_NEAR(thesis.x[i], static_cast<double>(kernels.x[i]), tolerance);
        ASSERT_NEAR(thesis.y[i], static_cast<double>(kernels.y[i]), tolerance);
      }
    }
  }
}

} // namespace
} // namespace hdmbench
