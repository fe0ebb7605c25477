// What `run --accuracy` promises: a field near enough and a cost that follows the request; images that sample
// a scene.

#include "harness/judge/truths.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/sampled_image.hpp"
#include "harness/solve/planner.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/finite_elements.hpp"
#include "test/sessions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {
namespace {

Plan plan(const Scene& scene, const Request& request) {
  return solve_as_needed(scene, request, test::find("openmp"), {}, test::silent());
}

ReferenceField truth_of(const Scene& scene) {
  return solve_finite_elements(elastic_problem(scene.full), ElementRule::plane_stress(scene.poisson));
}

double distance(const Plan& plan, const ReferenceField& truth) {
  return rmsd(ReferenceField(plan.solution.displacement), truth);
}

Scene scene_at(const char* name, int size) {
  Scene scene = load_scene(name, {.size = Extent{size, size}});
  use_method(scene, usual_method(EnergyModel::elastic));
  return scene;
}

TEST(Planner, GivesWhatIsAskedForAndCostsMoreTheMoreIsAsked) {
  for (const char* name : {"square", "circular", "circular-radial", "square-modified"}) {
    const Scene scene = scene_at(name, 150);
    const ReferenceField truth = truth_of(scene);
    double cost_before = 0.0;
    for (const double asked : {2.0, 0.5, 0.1, 0.02, 0.002}) {
      const Plan found = plan(scene, {.accuracy = asked});
      EXPECT_TRUE(found.met) << name << ", " << asked << ": " << found.outcome;
      EXPECT_LE(*found.solution.estimated_error, asked) << name;
      EXPECT_LE(distance(found, truth), asked) << name << ": " << found.outcome;
      EXPECT_GE(fine_sweep_equivalents(found), cost_before) << name << ", " << asked;
      cost_before = fine_sweep_equivalents(found);
    }
  }
}

TEST(Planner, AConditionOnOnePixelIsNotLost) {
  Scene scene = scene_at("square", 200);
  const std::size_t lonely = scene.full.extent.index(101, 67); // on no sampled image
  scene.full.target.x[lonely] = 30.0F;
  scene.full.confidence.x[lonely] = 1.0F;
  const ReferenceField truth = truth_of(scene);
  for (const double asked : {2.0, 0.1}) {
    const Plan found = plan(scene, {.accuracy = asked});
    EXPECT_TRUE(found.met) << found.outcome;
    EXPECT_LE(distance(found, truth), asked);
    EXPECT_EQ(found.solution.displacement.x[lonely], 30.0F);
  }
}

TEST(Planner, SaysWhenItCannot) {
  const Plan found = plan(scene_at("circular", 100), {.accuracy = 1e-9});
  EXPECT_FALSE(found.met);
  EXPECT_NE(found.outcome.find("NOT met"), std::string::npos) << found.outcome;
}

TEST(Planner, LittleTimeGivesACoarseField) {
  const Scene scene = scene_at("circular", 300);
  const Plan hasty = plan(scene, {.seconds = 1e-6});
  EXPECT_FALSE(hasty.met);
  EXPECT_EQ(hasty.solution.displacement.extent, scene.extent());
  EXPECT_LT(fine_sweep_equivalents(hasty), fine_sweep_equivalents(plan(scene, {.accuracy = 1e-3})) / 5.0);
}

TEST(Planner, RefusesNonsense) {
  const Scene scene = scene_at("square", 32);
  EXPECT_THROW((void)plan(scene, {.accuracy = 0.0}), InputError);
  EXPECT_THROW((void)plan(scene, {.accuracy = -1.0}), InputError);
  EXPECT_THROW((void)plan(scene, {.seconds = 0.0}), InputError);
  EXPECT_THROW((void)plan(load_scene("square"), {.accuracy = 1.0}), InputError); // the thesis's energy
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
