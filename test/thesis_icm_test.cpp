#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/thesis_energy.hpp"
#include "reference/thesis_icm.hpp"
#include "test/random_level.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace hdmbench {
namespace {

constexpr const char* dyadic_steps = "0,-1,1,-0.25,0.25,-0.5,0.5";

/// The first step of the lowest of `energies`.
std::size_t first_lowest(const std::vector<double>& energies) {
  return static_cast<std::size_t>(std::ranges::min_element(energies) - energies.begin());
}

/// Sites of a component whose next value is not that of ThesisEnergy's first best candidate, and is worse
/// than it by more than `tolerance` of the energy.
std::size_t wrong_choices(const Level& level, const ReferenceField& before, const ReferenceField& after,
                          double tolerance) {
  const ThesisEnergyOf<ReferenceField> energy(level, before);
  std::size_t wrong = 0;
  const auto check = [&](const std::vector<double>& energies, double from, double to) {
    const auto steps = level.steps.values();
    const std::size_t best = first_lowest(energies);
    bool accepted = false;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const bool as_good =
          i == best || (tolerance > 0.0 && energies[i] <= energies[best] * (1.0 + tolerance));
      accepted = accepted || (as_good && to == from + static_cast<double>(steps[i]));
    }
    wrong += accepted ? 0 : 1;
  };
  for_each_site(level.extent, [&](int x, int y) {
    const auto i = level.extent.index(x, y);
    std::vector<double> in_x;
    std::vector<double> in_y;
    for (const float step : level.steps.values()) {
      const auto value =
          energy.at(x, y, {before.x[i] + static_cast<double>(step), before.y[i] + static_cast<double>(step)});
      in_x.push_back(value.x);
      in_y.push_back(value.y);
    }
    check(in_x, before.x[i], after.x[i]);
    check(in_y, before.y[i], after.y[i]);
  });
  return wrong;
}

TEST(ThesisIcm, EverySiteTakesTheFirstBestCandidateOfTheThesisEnergy) {
  for (const Extent extent : {Extent{23, 17}, Extent{1, 1}, Extent{1, 7}, Extent{6, 1}, Extent{2, 2}}) {
    for (const char* steps : {"default", "thesis", "fine"}) {
      const auto [level, start] =
          test::random_problem(extent, test::Texture::smooth, 4, StepSet::parse(steps));
      ReferenceField field(start);
      for (int iteration = 0; iteration < 3; ++iteration) {
        const ReferenceField next = thesis_iteration(level, field);
        EXPECT_EQ(wrong_choices(level, field, next, 1e-13), 0U) << extent.width << " x " << extent.height;
        field = next;
      }
    }
  }
}

TEST(ThesisIcm, TiesGoToTheFirstCandidate) {
  // Every operation is exact, so a tie is a tie in any order of summation.
  const auto [level, start] =
      test::random_problem({29, 31}, test::Texture::dyadic, 6, StepSet::parse(dyadic_steps));
  ReferenceField field(start);
  std::size_t tied = 0;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const ReferenceField next = thesis_iteration(level, field);
    EXPECT_EQ(wrong_choices(level, field, next, 0.0), 0U) << "iteration " << iteration;
    Level reversed = level;
    reversed.steps = StepSet::parse("0.5,-0.5,0.25,-0.25,1,-1,0");
    tied += thesis_iteration(reversed, field).x != next.x ? 1 : 0;
    field = next;
  }
  EXPECT_GT(tied, 0U) << "no two candidates ever tied";
}

TEST(ThesisIcm, BadInputIsRefused) {
  const auto [level, start] = test::random_problem({5, 4}, test::Texture::smooth, 1);
  EXPECT_THROW((void)thesis_iteration(level, ReferenceField({4, 5})), InputError);
  Level bad = level;
  bad.modulus.values[2] = 0.0F;
  EXPECT_THROW((void)thesis_iteration(bad, ReferenceField(start)), InputError);
  ReferenceField short_field({5, 4});
  short_field.y.pop_back();
  EXPECT_THROW((void)thesis_prolongation(short_field, {10, 8}, Alignment::corner), InputError);
  EXPECT_THROW((void)thesis_prolongation(ReferenceField({5, 4}), {0, 8}, Alignment::corner), InputError);
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

TEST(ThesisProlongation, KeepsLinearFieldsToDouble) {
  const Extent coarse{128, 64};
  const Extent fine{257, 130};
  ReferenceField field(coarse);
  const auto linear = [](int x, int y, Extent extent) {
    return 3.0 + 8.0 * x / (extent.width - 1.0) - 4.0 * y / (extent.height - 1.0);
  };
  for_each_site(coarse, [&](int x, int y) { field.x[coarse.index(x, y)] = linear(x, y, coarse); });
  const ReferenceField result = thesis_prolongation(field, fine, Alignment::corner);
  for (int y = 0; y < fine.height; ++y) {
    for (int x = 0; x < fine.width; ++x) {
      ASSERT_NEAR(result.x[fine.index(x, y)], linear(x, y, fine), 1e-13);
    }
  }
}

} // namespace
} // namespace hdmbench
