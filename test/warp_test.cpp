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
  for (const Extent extent : {Extent{1, 1}, Extent{1, 7}, Extent{7, 1}, Extent{2, 2}, Extent{23, 19},
                              Extent{9, 8, 7}, Extent{5, 90}, Extent{3, 4, 70}}) { // the last two in bands
    const ScalarField picture = some_picture(extent);
    for (const auto& by :
         {std::array{0, 0, 0}, {3, 0, -2}, {-4, 7, 0}, {0, -18, 1}, {40, 0, 0}, {-3, -2, -1}}) {
      VectorField displacement(extent);
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        std::ranges::fill(displacement[axis], static_cast<float>(by[axis]));
      }
      const ScalarField warped = warp(picture, displacement);
      for_each_site(extent, [&](int x, int y, int z) {
        const std::array from{x - by[0], y - by[1], extent.axes() == 3 ? z - by[2] : 0};
        bool arrives = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          arrives = arrives && from[axis] >= 0 && from[axis] < extent.sides()[axis];
        }
        EXPECT_EQ(warped.values[extent.index(x, y, z)],
                  arrives ? picture.values[extent.index(from[0], from[1], from[2])] : 0.0F);
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

TEST(Warp, APlaneIsThatOfTheWholeVolume) {
  const Extent extent{9, 8, 7};
  const ScalarField picture = some_picture(extent);
  VectorField displacement(extent);
  ScalarField linear(extent);
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t site = extent.index(x, y, z);
    linear.values[site] = static_cast<float>(100 + x + 10 * y - 5 * z);
    displacement[0][site] = 0.25F * static_cast<float>(z - 3); // shears and grows about the middle
    displacement[1][site] = 0.5F * static_cast<float>(y - 4);
    displacement[2][site] = 0.0F;
  });
  const ScalarField grown = warp(linear, displacement);
  EXPECT_NEAR(grown.values[extent.index(4, 6, 5)], 100 + 3.5 + 10 * (4 + 2 / 1.5) - 25, 1e-4);
  const Extent in_bands{11, 8, 70};
  for (const auto& [seen, field] : {std::pair{picture, displacement},
                                    {picture, some_displacement(extent)},
                                    {some_picture(in_bands), some_displacement(in_bands)}}) {
    const ScalarField whole = warp(seen, field);
    for (const Plane plane : {Plane{0, 0}, Plane{1, 3}, Plane{2, 6}, Plane{2, field.extent.depth / 2}}) {
      EXPECT_EQ(warp(seen, field, plane).values, slice_of(whole, plane).values);
    }
  }
}

TEST(Slices, AreWhereTheVolumeMovesMost) {
  VectorField field({6, 4, 4});
  field[0][field.extent.index(4, 1, 2)] = 1.0F;
  field[2][field.extent.index(4, 1, 2)] = -3.0F;
  field[1][field.extent.index(0, 0, 0)] = 3.1F;
  std::vector<ScalarField> slices;
  for (const Plane& plane : planes_to_show(magnitude_of(field))) {
    const VectorField within = slice_of(field, plane);
    EXPECT_EQ(within.extent, (std::array{Extent{4, 4}, Extent{6, 4}, Extent{6, 4}}[plane.axis]));
    EXPECT_EQ(std::ranges::max(magnitude_of(within).values),
              plane.axis == 2 ? 1.0F : std::hypot(plane.axis == 1 ? 1.0F : 0.0F, 3.0F));
    slices.push_back(slice_of(magnitude_of(field), plane));
  }
  const ScalarField row = side_by_side(slices);
  EXPECT_EQ(row.extent, (Extent{16, 4}));
  for (const auto& [x, y] : {std::pair{4, 1}, {6 + 4, 2}, {12 + 1, 2}}) {
    EXPECT_EQ(row.values[row.extent.index(x, y)], std::hypot(1.0F, 3.0F));
  }
  EXPECT_EQ(std::ranges::count(row.values, 0.0F), 16 * 4 - 3);
  field[1][field.extent.index(5, 3, 0)] = 9.0F;
  const std::vector<Plane> planes = planes_to_show(magnitude_of(field));
  EXPECT_EQ((std::array{planes[2].at, planes[1].at, planes[0].at}), (std::array{3, 2, 2}))
      << "a corner shows nothing: the middle";
  EXPECT_EQ(planes_to_show(ScalarField({6, 4})).size(), 1U) << "an image is its own slice";
  // A large volume is shown by some of its sites, and what moves there moves by as many fewer of them.
  ScalarField picture({150, 100, 2}, 50.0F);
  EXPECT_EQ(contact_sheet(picture, VectorField(picture.extent)).volume, picture.extent);
  picture = ScalarField({200, 150, 20});
  VectorField shift(picture.extent);
  std::ranges::fill(shift[0], 20.0F);
  picture.values[picture.extent.index(100, 80, 10)] = 200.0F;
  const ContactSheet sheet = contact_sheet(picture, shift);
  EXPECT_EQ(sheet.volume, (Extent{100, 75, 10}));
  const auto shown = [&](int tile, int x, int y) {
    const int columns = sheet.picture.extent.width / 100;
    return sheet.picture
        .values[sheet.picture.extent.index(tile % columns * 100 + x, tile / columns * 75 + y)];
  };
  EXPECT_EQ(shown(5, 50, 40), 200.0F);
  EXPECT_EQ(shown(15, 60, 40), 200.0F) << "after: ten sites of the sheet further";
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
