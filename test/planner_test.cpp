// What `run --accuracy` promises: an estimate that is honest and a cost that follows the request.

#include "harness/judge/accuracy/deviation.hpp"
#include "harness/solve/methods/sampled_image.hpp"
#include "harness/solve/planner/planner.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/fixed_point.hpp"
#include "test/random_scene.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace hdmbench {
namespace {

class PlannerTest : public testing::Test {
protected:
  Plan plan(const Scene& scene, const Request& request) {
    return solve_as_needed(scene, request, test::find("openmp"), {}, sessions_, test::silent());
  }

  static double distance(const Plan& plan, const ReferenceField& truth) {
    return rmsd(ReferenceField(plan.solution.displacement), truth);
  }

  static double cost(const Plan& plan) {
    return total_site_updates(plan.solution.levels) /
           static_cast<double>(plan.solution.displacement.extent.sites());
  }

  std::vector<std::unique_ptr<Session>> sessions_;
};

Scene scene_at(const char* name, int size) {
  return load_scene(name, {.size = Extent{size, size}});
}

TEST_F(PlannerTest, GivesWhatIsAskedForAndCostsMoreTheMoreIsAsked) {
  for (const char* name : {"square", "circular", "circular-radial", "square-modified"}) {
    const Scene scene = scene_at(name, 150);
    const ReferenceField truth = solve_fixed_point(scene.full).displacement;
    double cost_before = 0.0;
    for (const double asked : {2.0, 0.5, 0.1, 0.02, 0.002}) {
      const Plan found = plan(scene, {.accuracy = asked});
      EXPECT_TRUE(found.met) << name << ", " << asked << ": " << found.outcome;
      EXPECT_LE(*found.solution.estimated_error, asked) << name;
      EXPECT_LE(distance(found, truth), asked) << name << ": " << found.outcome;
      EXPECT_GE(cost(found), cost_before) << name << ", " << asked;
      cost_before = cost(found);
    }
  }
}

TEST_F(PlannerTest, TheEstimateIsHonest) {
  std::vector<double> ratios;
  int unmet = 0;
  int broken_promises = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Scene scene = test::random_scene(seed, {.smallest = 20, .largest = 70});
    const double asked = std::array{2.0, 0.5, 0.1, 0.02}[seed % 4];
    const Plan found = plan(scene, {.accuracy = asked});
    const double truth = distance(found, solve_fixed_point(scene.full).displacement);
    ratios.push_back(truth / *found.solution.estimated_error);
    if (ratios.back() > 2.0) {
      fmt::print("random_scene({}), {} x {}: {}; truth {:.3g} px, last {} from {}\n", seed,
                 scene.extent().width, scene.extent().height, found.outcome, truth, found.steps.back().action,
                 found.steps[found.steps.size() - 2].extent.width);
    }
    unmet += found.met ? 0 : 1;
    broken_promises += found.met && truth > asked ? 1 : 0;
  }
  std::ranges::sort(ratios);
  const auto quantile = [&](double share) {
    return ratios[static_cast<std::size_t>(share * static_cast<double>(ratios.size()))];
  };
  fmt::print("true / estimated error over {} scenes: median {:.2f}, 95 % {:.2f}, largest {:.2f}; {} not met, "
             "{} said "
             "to be met but not\n",
             ratios.size(), quantile(0.5), quantile(0.95), ratios.back(), unmet, broken_promises);
  EXPECT_LE(quantile(0.95), 2.0);
  EXPECT_GE(quantile(0.5), 0.1) << "an estimate that is always far too high helps nobody";
  EXPECT_LE(unmet, 10);
  EXPECT_LE(broken_promises, 4);
}

TEST_F(PlannerTest, AHomogeneousSheetCostsNextToNothing) {
  Scene scene = scene_at("square", 300);
  std::ranges::fill(scene.full.modulus.values, 10.0F);
  set_inverse_modulus(scene.full);
  const Plan found = plan(scene, {.accuracy = 0.02});
  EXPECT_TRUE(found.met) << found.outcome;
  EXPECT_LT(cost(found), 0.3);
  EXPECT_LE(distance(found, solve_fixed_point(scene.full).displacement), 0.02);
}

TEST_F(PlannerTest, AConditionOnOnePixelIsNotLost) {
  Scene scene = scene_at("square", 200);
  const std::size_t lonely = scene.full.extent.index(101, 67); // on no coarse level
  scene.full.target.x[lonely] = 30.0F;
  scene.full.confidence.x[lonely] = 1.0F;
  const ReferenceField truth = solve_fixed_point(scene.full).displacement;
  for (const double asked : {2.0, 0.1}) {
    const Plan found = plan(scene, {.accuracy = asked});
    EXPECT_TRUE(found.met) << found.outcome;
    EXPECT_LE(distance(found, truth), asked);
    EXPECT_EQ(found.solution.displacement.x[lonely], 30.0F);
  }
}

TEST_F(PlannerTest, SaysWhenItCannot) {
  const Plan found = plan(scene_at("circular", 100), {.accuracy = 1e-9});
  EXPECT_FALSE(found.met);
  EXPECT_NE(found.outcome.find("NOT met"), std::string::npos) << found.outcome;
}

TEST_F(PlannerTest, LittleTimeGivesACoarseFieldWithItsEstimate) {
  const Scene scene = scene_at("circular", 300);
  const ReferenceField truth = solve_fixed_point(scene.full).displacement;
  const Plan hasty = plan(scene, {.seconds = 1e-6});
  EXPECT_FALSE(hasty.met);
  EXPECT_EQ(hasty.solution.displacement.extent, scene.extent());
  const Plan patient = plan(scene, {.accuracy = 1e-4, .seconds = 30.0});
  EXPECT_TRUE(patient.met) << patient.outcome;
  EXPECT_LT(distance(patient, truth), 1e-3);
  EXPECT_LT(cost(hasty), cost(patient) / 10.0);
}

TEST_F(PlannerTest, RefusesNonsense) {
  const Scene scene = scene_at("square", 32);
  EXPECT_THROW((void)plan(scene, {.accuracy = 0.0}), InputError);
  EXPECT_THROW((void)plan(scene, {.accuracy = -1.0}), InputError);
  EXPECT_THROW((void)plan(scene, {.seconds = 0.0}), InputError);
}

TEST(Survey, CountsWhatASceneIsMadeOf) {
  const Scene scene = scene_at("square", 97);
  const std::vector<Extent> extents{{97, 97}, {33, 33}, {4, 4}};
  const Survey found = survey(scene);
  EXPECT_EQ(found.smallest_modulus, 10.0);
  EXPECT_EQ(found.largest_modulus, 20.0);
  EXPECT_EQ(found.smallest_target, -50.0);
  EXPECT_EQ(found.largest_target, 50.0);
  EXPECT_NEAR(found.observed, 4.0 * 97.0 / (2.0 * 97.0 * 97.0), 1e-12);
  const std::vector<Resolution> levels = resolutions(scene, extents);
  EXPECT_EQ(levels.front().materials, 1.0);
  EXPECT_EQ(levels.front().conditions, 1.0);
  EXPECT_GT(levels[1].materials, levels[2].materials);
  EXPECT_EQ(fair_start(levels), 1U);
}

/// In one pass what prolongate() and a look at every site do.
TEST(SampledImage, IsInterpolatedAndPutOnTheTargets) {
  for (const Extent extent : {Extent{1, 1}, Extent{67, 5}, Extent{300, 170}}) {
    Scene scene = load_scene("random", {.size = extent});
    Level& full = scene.full;
    const VectorField coarse = sample_field(full.target, sampled_extent(extent, 4), Alignment::corner);
    VectorField expected = prolongate(coarse, extent, Alignment::corner);
    Level sampled = sample_level(full, coarse.extent, Alignment::corner);
    std::ranges::fill(sampled.confidence.y, 0.0F); // so nothing of y is known
    double squares = 0.0;
    double count = 0.0;
    double unknown_of_y = 0.0;
    const auto impose = [&](std::vector<float>& values, const std::vector<float>& target,
                            const std::vector<float>& confidence) {
      double largest = 0.0;
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (confidence[i] > 0.0F) {
          const auto gap = static_cast<double>(std::abs(target[i] - values[i]));
          squares += gap * gap;
          count += 1.0;
          largest = std::max(largest, gap);
          values[i] = target[i];
        }
      }
      return largest;
    };
    const double largest_of_x = impose(expected.x, full.target.x, full.confidence.x);
    unknown_of_y = impose(expected.y, full.target.y, full.confidence.y);
    const Interpolated found = interpolate_to_image(coarse, sampled, full, Alignment::corner);
    EXPECT_EQ(found.field.x, expected.x);
    EXPECT_EQ(found.field.y, expected.y);
    EXPECT_NEAR(found.gap, std::sqrt(2.0 * squares / count), 1e-6 * found.gap); // sums of 64 are in float
    EXPECT_GE(found.largest_unknown_gap, unknown_of_y);
    EXPECT_LE(found.largest_unknown_gap, std::max(unknown_of_y, largest_of_x));
    EXPECT_EQ(found.has_springs, has_springs(full));
  }
}

/// An interface has its place to a fraction of a pixel, a layer its share, in both means.
TEST(SampledImage, HasMeansOfItsBlocks) {
  const Extent extent{13, 9};
  Level full{.extent = extent, .modulus = ScalarField(extent, 1.0F)};
  for (int y = 0; y < extent.height; ++y) {
    full.modulus.values[extent.index(6, y)] = 5.0F; // a layer of one pixel
  }
  set_inverse_modulus(full);
  const BlockModuli blocks = block_moduli(full.modulus, full.inverse_modulus, {4, 3}, Alignment::corner);
  // Cells of 4 pixels: site 1 stands for 2 ... 6 on the axis, half of pixel 6 among them.
  const Extent sites = blocks.mean.extent;
  EXPECT_FLOAT_EQ(blocks.mean.values[sites.index(0, 1)], 1.0F);
  EXPECT_FLOAT_EQ(blocks.mean.values[sites.index(1, 1)], (3.5F + 0.5F * 5.0F) / 4.0F);
  EXPECT_FLOAT_EQ(blocks.mean.values[sites.index(2, 0)], (3.5F + 0.5F * 5.0F) / 4.0F);
  EXPECT_FLOAT_EQ(blocks.inverse_mean.values[sites.index(1, 1)], (3.5F + 0.5F / 5.0F) / 4.0F);
  EXPECT_FLOAT_EQ(blocks.mean.values[sites.index(3, 2)], 1.0F);
  EXPECT_NEAR(largest_mixture(blocks), (3.5 + 2.5) / 4.0 * (3.5 + 0.1) / 4.0, 1e-5);
  // Means of an image that is as large are its moduli.
  // Of pixels' areas: site 1 of 5 stands for 2.6 ... 5.2 pixel widths, site 2 to 7.8, so it has the layer.
  const BlockModuli areas = block_moduli(full.modulus, full.inverse_modulus, {5, 9}, Alignment::center);
  EXPECT_FLOAT_EQ(areas.mean.values[1], 1.0F);
  EXPECT_FLOAT_EQ(areas.mean.values[2], (1.6F + 5.0F) / 2.6F);
  for (const Alignment alignment : {Alignment::corner, Alignment::center}) {
    EXPECT_EQ(block_moduli(full.modulus, full.inverse_modulus, extent, alignment).mean.values,
              full.modulus.values);
    EXPECT_FLOAT_EQ(block_moduli(full.modulus, full.inverse_modulus, {1, 1}, alignment).mean.values[0],
                    (12.0F + 5.0F) / 13.0F);
  }
}

TEST(SampledImage, HasSquareCells) {
  EXPECT_EQ(sampled_extent({300, 300}, 4), (Extent{76, 76}));
  EXPECT_EQ(sampled_extent({257, 130}, 8), (Extent{33, 17}));
  EXPECT_EQ(sampled_extent({5, 1}, 1), (Extent{5, 1}));
}

} // namespace
} // namespace hdmbench
