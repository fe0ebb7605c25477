#include "harness/check/compare.hpp"
#include "harness/judge/registration/elastic_registration.hpp"
#include "harness/scene/sites.hpp"
#include "test/image_files.hpp"
#include "test/sessions.hpp"

#include <cmath>
#include <limits>
#include <random>

namespace hdmbench {
namespace {

/// Soft spots of random place, width and brightness.
ScalarField textured(Extent extent) {
  std::mt19937 random(5);
  const auto uniform = [&random] { return static_cast<double>(random() % 10001) * 1e-4; };
  ScalarField picture(extent, 40.0F);
  const auto spots = extent.sites() / 60;
  for (std::size_t spot = 0; spot < spots; ++spot) {
    const double centre_x = uniform() * extent.width;
    const double centre_y = uniform() * extent.height;
    const double width = 2.0 + 4.0 * uniform();
    const double brightness = 120.0 * (uniform() - 0.5);
    for_each_site(extent, [&](int x, int y) {
      const double squared = std::pow(x - centre_x, 2) + std::pow(y - centre_y, 2);
      picture.values[extent.index(x, y)] +=
          static_cast<float>(brightness * std::exp(-0.5 * squared / (width * width)));
    });
  }
  return picture;
}

/// Up to `amplitude` pixels, 0 at the border.
VectorField smooth_displacement(Extent extent, double amplitude) {
  VectorField field(extent);
  for_each_site(extent, [&](int x, int y) {
    const double across = std::sin(M_PI * x / (extent.width - 1));
    const double down = std::sin(M_PI * y / (extent.height - 1));
    field.x[extent.index(x, y)] = static_cast<float>(amplitude * across * down);
    field.y[extent.index(x, y)] = static_cast<float>(-0.6 * amplitude * across * down * down);
  });
  return field;
}

/// Root of the mean of |a - b|^2, pixels, over the sites at least `margin` from the border.
double rmsd(const VectorField& a, const VectorField& b, int margin) {
  double sum = 0.0;
  int count = 0;
  for (int y = margin; y < a.extent.height - margin; ++y) {
    for (int x = margin; x < a.extent.width - margin; ++x) {
      const std::size_t site = a.extent.index(x, y);
      sum += std::pow(double{a.x[site]} - b.x[site], 2) + std::pow(double{a.y[site]} - b.y[site], 2);
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

RegistrationResult registered(const ScalarField& fixed, const ScalarField& moving,
                              const RegistrationOptions& options = {}) {
  return register_elastically(fixed, moving, options, test::silent());
}

class Registration : public testing::Test {
protected:
  void SetUp() override {
    if (!have_images()) {
      GTEST_SKIP() << "built without ITK (HDMBENCH_IMAGES=OFF)";
    }
  }
};

TEST_F(Registration, RecoversAKnownDeformation) {
  for (const Extent extent : {Extent{96, 80}, Extent{50, 130}}) {
    const ScalarField fixed = textured(extent);
    const VectorField truth = smooth_displacement(extent, 6.0);
    const RegistrationResult result = registered(fixed, warp(fixed, truth));
    const double before = rmsd(VectorField(extent), truth, 8);
    const double after = rmsd(result.displacement, truth, 8);
    EXPECT_GT(before, 3.0);
    EXPECT_LT(after, 0.15);
    EXPECT_LT(result.mean_squares, 1.0);
    EXPECT_GT(result.iterations, 10);
    EXPECT_GT(result.seconds, 0.0);
  }
}

TEST_F(Registration, RecoversAnExpansionOfTenPixels) {
  // The thesis's case in small: edges only, flat in between.
  const Extent extent{120, 120};
  ScalarField fixed(extent, 20.0F);
  VectorField truth(extent);
  std::vector<bool> inside(extent.sites());
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 120; ++x) {
      const std::size_t site = extent.index(x, y);
      inside[site] = std::hypot(x - 60, y - 60) < 36;
      fixed.values[site] = !inside[site] ? 20.0F : std::hypot(x - 50, y - 55) < 8 ? 235.0F : 150.0F;
      truth.x[site] = static_cast<float>(x - 60) * 0.25F;
      truth.y[site] = static_cast<float>(y - 60) * 0.25F;
    }
  }
  const RegistrationResult result = registered(fixed, warp(fixed, truth));
  double sum = 0.0;
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    if (inside[site]) {
      sum += std::pow(double{result.displacement.x[site]} - truth.x[site], 2) +
             std::pow(double{result.displacement.y[site]} - truth.y[site], 2);
    }
  }
  EXPECT_LT(std::sqrt(sum / static_cast<double>(std::ranges::count(inside, true))), 0.5);
}

TEST_F(Registration, LeavesEqualPicturesWhereTheyAre) {
  const ScalarField picture = textured({64, 48});
  const RegistrationResult result = registered(picture, picture);
  EXPECT_EQ(rmsd(result.displacement, VectorField(picture.extent), 0), 0.0);
  EXPECT_EQ(result.mean_squares, 0.0);
}

TEST_F(Registration, GivesTheSameBitsEachTimeAndAtAnyContrast) {
  const Extent extent{64, 64};
  const ScalarField fixed = textured(extent);
  const ScalarField moving = warp(fixed, smooth_displacement(extent, 4.0));
  const RegistrationResult first = registered(fixed, moving);
  EXPECT_EQ(compare(first.displacement, registered(fixed, moving).displacement).sites, 0);
  const auto doubled = [](ScalarField picture) {
    for (float& gray : picture.values) {
      gray *= 2.0F;
    }
    return picture;
  };
  const RegistrationResult brighter = registered(doubled(fixed), doubled(moving));
  EXPECT_EQ(compare(first.displacement, brighter.displacement).sites, 0);
  EXPECT_NEAR(brighter.mean_squares, 4.0 * first.mean_squares, 1e-9 * brighter.mean_squares);
}

TEST_F(Registration, GoesOnAnySizeFrom16) {
  for (const Extent extent : {Extent{16, 16}, Extent{17, 90}, Extent{200, 16}}) {
    SCOPED_TRACE(testing::Message() << extent.width << " x " << extent.height);
    const ScalarField fixed = textured(extent);
    const VectorField truth = smooth_displacement(extent, 1.5);
    for (const int levels : {1, 10}) {
      const auto result = registered(fixed, warp(fixed, truth), {.levels = levels});
      EXPECT_LT(rmsd(result.displacement, truth, 4), 0.4 * rmsd(VectorField(extent), truth, 4)) << levels;
    }
  }
}

TEST_F(Registration, DoesNoMoreIterationsThanAsked) {
  const Extent extent{64, 64};
  const ScalarField fixed = textured(extent);
  const ScalarField moving = warp(fixed, smooth_displacement(extent, 6.0));
  for (const int iterations : {0, 1, 7}) {
    const int done = registered(fixed, moving, {.levels = 3, .iterations = iterations}).iterations;
    EXPECT_LE(done, 3 * iterations);
    EXPECT_GE(done, std::min(2, iterations)); // a line search may fail early
  }
}

TEST_F(Registration, ReportsProgress) {
  const ScalarField picture = textured({32, 32});
  std::vector<double> seen;
  Progress progress([&seen](double done) { seen.push_back(done); });
  progress.set_total(3.0);
  (void)register_elastically(picture, picture, {.levels = 3}, progress);
  EXPECT_EQ(seen, (std::vector{1.0 / 3.0, 2.0 / 3.0, 1.0}));
}

TEST_F(Registration, RefusesWhatCannotBeRegistered) {
  const ScalarField picture = textured({32, 24});
  const auto refuse = [&](const ScalarField& fixed, const ScalarField& moving, const char* part,
                          const RegistrationOptions& options = {}) {
    expect_refusal([&] { (void)registered(fixed, moving, options); }, part);
  };
  refuse(picture, textured({32, 25}), "the moving picture is 32 x 25, the other one 32 x 24");
  refuse(textured({32, 15}), textured({32, 15}), "at least 16 x 16");
  refuse(ScalarField({32, 24}, 7.0F), picture, "the gray values of the fixed picture are 7 ... 7");
  refuse(picture, ScalarField({32, 24}), "the gray values of the moving picture are 0 ... 0");
  ScalarField damaged = picture;
  damaged.values[damaged.extent.index(3, 2)] = std::numeric_limits<float>::quiet_NaN();
  refuse(damaged, picture, "the fixed picture at x = 3, y = 2 is nan");
  refuse(picture, damaged, "the moving picture at x = 3, y = 2 is nan");
  refuse(picture, picture, "the number of levels is 0", {.levels = 0});
  refuse(picture, picture, "the grid spacing is 1", {.grid_spacing = 1.0});
  refuse(picture, picture, "the blur is -1", {.blur = -1.0});
  refuse(picture, picture, "the smoothness is nan", {.smoothness = std::numeric_limits<double>::quiet_NaN()});
  refuse(picture, picture, "the number of iterations is -5", {.iterations = -5});
}

TEST(RegistrationWithoutItk, SaysWhatIsMissing) {
  if (have_images()) {
    GTEST_SKIP() << "this build has ITK";
  }
  expect_refusal(
      [] {
        (void)registered(ScalarField({16, 16}), ScalarField({16, 16}));
      },
      "HDMBENCH_IMAGES=ON");
}

} // namespace
} // namespace hdmbench
