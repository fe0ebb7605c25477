#include "harness/scene/sites.hpp"
#include "test/files.hpp"

namespace hdmbench {
namespace {

ScalarField some_picture(Extent extent) {
  ScalarField picture(extent);
  std::mt19937 random(2);
  std::ranges::generate(picture.values,
                        [&random] { return 1.0F + static_cast<float>(random() % 2540) * 0.1F; });
  return picture;
}

TEST(Warp, IntegerTranslationIsExact) {
  for (const Extent extent : {Extent{1, 1}, Extent{1, 7}, Extent{7, 1}, Extent{2, 2}, Extent{23, 19}}) {
    const ScalarField picture = some_picture(extent);
    for (const auto& [dx, dy] : {std::pair{0, 0}, {3, 0}, {-4, 7}, {0, -18}, {40, 0}}) {
      VectorField displacement(extent);
      std::ranges::fill(displacement[0], static_cast<float>(dx));
      std::ranges::fill(displacement[1], static_cast<float>(dy));
      const ScalarField warped = warp(picture, displacement);
      for_each_site(extent, [&, dx = dx, dy = dy](int x, int y) {
        const bool arrives = x - dx >= 0 && x - dx < extent.width && y - dy >= 0 && y - dy < extent.height;
        EXPECT_EQ(warped.values[extent.index(x, y)],
                  arrives ? picture.values[extent.index(x - dx, y - dy)] : 0.0F);
      });
    }
  }
}

TEST(Warp, LinearMapOfALinearPictureIsExact) {
  const Extent extent{40, 30};
  ScalarField picture(extent);
  VectorField displacement(extent);
  for_each_site(extent, [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    picture.values[site] = 10.0F + 3.0F * static_cast<float>(x) + 2.0F * static_cast<float>(y);
    displacement[0][site] = 0.5F * static_cast<float>(x - 20);
    displacement[1][site] = -0.25F * static_cast<float>(y - 16);
  });
  const ScalarField warped = warp(picture, displacement);
  for (int y = 4; y <= 26; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const double from_x = 20.0 + (x - 20.0) / 1.5;
      const double from_y = 16.0 + (y - 16.0) / 0.75;
      if (from_y >= 0.0 && from_y <= 29.0) {
        EXPECT_NEAR(warped.values[extent.index(x, y)], 10.0 + 3.0 * from_x + 2.0 * from_y, 1e-4);
      }
    }
  }
  EXPECT_EQ(warped.values[extent.index(20, 0)], 0.0F); // the picture shrinks away from here
}

TEST(Warp, FoldsAreDrawn) {
  const Extent extent{64, 64};
  const ScalarField picture = some_picture(extent);
  const ScalarField warped = warp(picture, some_displacement(extent));
  const auto [low, high] = std::ranges::minmax(warped.values);
  EXPECT_GE(low, 0.0F);
  EXPECT_LE(high, std::ranges::max(picture.values) + 1e-3F);
  VectorField mirrored(extent);
  for_each_site(extent,
                [&](int x, int y) { mirrored[0][extent.index(x, y)] = static_cast<float>(63 - 2 * x); });
  const ScalarField mirror = warp(picture, mirrored);
  for (int x = 0; x < 64; ++x) {
    EXPECT_EQ(mirror.values[extent.index(x, 5)], picture.values[extent.index(63 - x, 5)]);
  }
  std::ranges::fill(mirrored[0], 1e30F);
  EXPECT_EQ(std::ranges::max(warp(picture, mirrored).values), 0.0F);
}

TEST(Warp, RefusesWhatIsNoDisplacement) {
  VectorField displacement({4, 4});
  displacement[0][5] = std::numeric_limits<float>::quiet_NaN();
  expect_refusal([&] { (void)warp(ScalarField({4, 4}), displacement); }, "x = 1, y = 1");
  expect_refusal([&] { (void)warp(ScalarField({4, 5}), VectorField({4, 4})); }, "4 x 5");
}

TEST(Grid, HasALineEverySoManyPixels) {
  for (const int every : {2, 5, 10}) {
    const Extent extent{100, 60};
    const ScalarField grid = grid_picture(extent, every);
    for_each_site(extent, [&](int x, int y) {
      const bool dark = (x + every / 2) % every == 0 || (y + every / 2) % every == 0;
      EXPECT_EQ(grid.values[extent.index(x, y)] == 0.0F, dark) << x << ", " << y << ", every " << every;
    });
  }
  expect_refusal([] { (void)grid_picture({10, 10}, 1); }, "every 1 pixels");
}

} // namespace
} // namespace hdmbench
