#include "test/files.hpp"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <set>
#include <utility>

namespace hdmbench {
namespace {

TEST_F(ImageFiles, ScalarsComeAsTheyAre) {
  const auto image =
      read_scalar(write_nrrd("a.nrrd", "float", "3 2", "1 -2.5 nan 1e30 inf 0", "spacings: 0.5 0.5\n"));
  EXPECT_EQ(image.pixels.extent, (Extent{3, 2}));
  EXPECT_EQ(image.spacing, 0.5);
  const auto& values = image.pixels.values;
  EXPECT_EQ(values[0], 1.0F);
  EXPECT_EQ(values[1], -2.5F);
  EXPECT_TRUE(std::isnan(values[2]));
  EXPECT_EQ(values[3], 1e30F);
  EXPECT_EQ(values[4], std::numeric_limits<float>::infinity());
  EXPECT_EQ(values[5], 0.0F);
}

TEST_F(ImageFiles, LabelsAreIntegers) {
  const auto labels = read_labels(write_nrrd("a.nrrd", "short", "2 2", "0 3 -1 300"));
  EXPECT_EQ(labels.pixels.values, (std::vector<int>{0, 3, -1, 300}));
  EXPECT_EQ(read_labels(write_nrrd("f.nrrd", "float", "2 1", "1 2.0")).pixels.values,
            (std::vector<int>{1, 2}));
  for (const auto* value : {"0.5", "nan", "inf", "16777216"}) {
    const auto file = write_nrrd("bad.nrrd", "double", "3 2", fmt::format("0 1 2 3 {} 0", value));
    expect_refusal([&] { (void)read_labels(file); }, "x = 1, y = 1");
  }
}

TEST_F(ImageFiles, VectorsHaveTwoOrThreeComponents) {
  const std::string kinds = "kinds: vector domain domain\n";
  for (const auto& [sizes, pixels] : {std::pair{"2 2 1", "1 2 3 4"}, std::pair{"3 2 1", "1 2 9 3 4 9"}}) {
    const auto field = read_vector(write_nrrd("v.nrrd", "float", sizes, pixels, kinds)).pixels;
    EXPECT_EQ(field.extent, (Extent{2, 1}));
    EXPECT_EQ(field.x, (std::vector<float>{1, 3}));
    EXPECT_EQ(field.y, (std::vector<float>{2, 4}));
  }
  const auto vectors = write_nrrd("v.nrrd", "float", "2 2 1", "1 2 3 4", kinds);
  expect_refusal([&] { (void)read_scalar(vectors); }, "2 components");
  expect_refusal([&] { (void)read_labels(vectors); }, "2 components");
  const auto four = write_nrrd("4.nrrd", "float", "4 1 1", "1 2 3 4", kinds);
  expect_refusal([&] { (void)read_vector(four); }, "4 component");
  const auto one = write_nrrd("1.nrrd", "float", "1 2", "1 2");
  expect_refusal([&] { (void)read_vector(one); }, "1 component");
}

TEST_F(ImageFiles, SlicesAreChosen) {
  const auto volume = write_nrrd("3d.nrrd", "uchar", "2 1 3", "0 1 2 3 4 5");
  EXPECT_EQ(read_labels(volume, {.slice = 2, .size = {}}).pixels.values, (std::vector<int>{4, 5}));
  expect_refusal([&] { (void)read_labels(volume); }, "choose one of its slices 0 ... 2");
  expect_refusal([&] { (void)read_labels(volume, {.slice = 3, .size = {}}); }, "no slice 3");
  expect_refusal([&] { (void)read_labels(volume, {.slice = -1, .size = {}}); }, "no slice -1");

  const auto thin = write_nrrd("thin.nrrd", "uchar", "2 1 1", "6 7");
  EXPECT_EQ(read_labels(thin).pixels.values, (std::vector<int>{6, 7}));
  const auto flat = write_nrrd("2d.nrrd", "uchar", "2 1", "6 7");
  EXPECT_EQ(read_labels(flat, {.slice = 0, .size = {}}).pixels.values, (std::vector<int>{6, 7}));
  expect_refusal([&] { (void)read_labels(flat, {.slice = 1, .size = {}}); }, "no slice 1");
  const auto four = write_nrrd("4d.nrrd", "uchar", "1 1 1 2", "6 7");
  expect_refusal([&] { (void)read_labels(four, {.slice = 0, .size = {}}); }, "axis 4 has 2");
}

TEST_F(ImageFiles, ResamplingKeepsTheAspectRatio) {
  const auto file = write_nrrd("a.nrrd", "uchar", "4 2", "1 2 3 4 5 6 7 8", "spacings: 1 1\n");
  const auto square = read_labels(file, {.slice = {}, .size = Extent{4, 4}});
  EXPECT_EQ(square.pixels.values, (std::vector<int>{0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0, 0}));
  EXPECT_EQ(square.spacing, 1.0);
  const auto doubled = read_labels(file, {.slice = {}, .size = Extent{8, 4}});
  EXPECT_EQ(doubled.spacing, 0.5);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 8; ++x) {
      EXPECT_EQ(doubled.pixels.values[doubled.pixels.extent.index(x, y)], 1 + x / 2 + 4 * (y / 2));
    }
  }
  const auto halved = read_scalar(file, {.slice = {}, .size = Extent{2, 1}});
  EXPECT_EQ(halved.spacing, 2.0);
  EXPECT_EQ(halved.pixels.values, (std::vector<float>{3.5F, 5.5F}));
  expect_refusal([&] { (void)read_scalar(file, {.slice = {}, .size = Extent{0, 3}}); }, "0 x 3");
}

TEST_F(ImageFiles, PixelsMustBeSquare) {
  const auto file = write_nrrd("a.nrrd", "uchar", "2 1", "1 2", "spacings: 1 2\n");
  expect_refusal([&] { (void)read_labels(file); }, "must be square");
}

TEST_F(ImageFiles, DisplacementsSurviveTheRoundTrip) {
  const VectorField field = some_displacement({7, 5});
  constexpr double spacing = 0.74;
  for (const auto* name : {"d.nrrd", "d.mha"}) {
    write_displacement(path(name), field, spacing);
    const auto read = read_vector(path(name));
    EXPECT_EQ(read.spacing, spacing) << name;
    ASSERT_EQ(read.pixels.extent, field.extent) << name;
    for (std::size_t site = 0; site < field.x.size(); ++site) {
      EXPECT_EQ(read.pixels.x[site], static_cast<float>(double{field.x[site]} * spacing)) << name;
      EXPECT_EQ(read.pixels.y[site], static_cast<float>(double{field.y[site]} * spacing)) << name;
    }
  }
  EXPECT_EQ(files().size(), 2U);
  const std::string nrrd = content(path("d.nrrd"));
  for (const auto* line : {"\nhdmbench mapping:=forward: tissue at x moves to x + d(x)\n",
                           "\nhdmbench unit:=millimetre\n", "\nsizes: 3 7 5 1\n", "\nkinds: vector domain"}) {
    EXPECT_NE(nrrd.find(line), std::string::npos) << line;
  }
  const std::string meta = content(path("d.mha"));
  for (const auto* line : {"\nhdmbench mapping = forward: tissue at x moves to x + d(x)\n",
                           "\nhdmbench unit = millimetre\n", "\nDimSize = 7 5 1\n"}) {
    EXPECT_NE(meta.find(line), std::string::npos) << line;
  }
}

TEST_F(ImageFiles, DisplacementsComeBackFromAnywhereInSpace) {
  const double c = std::cos(0.2);
  const double s = std::sin(0.2);
  const Placement oblique{.origin = {-70.0, 33.0, 5.5},
                          .axes = {{{c, 0.0, s}, {0.0, -1.0, 0.0}, {s, 0.0, -c}}},
                          .thickness = 3.0};
  const VectorField field = some_displacement({7, 5});
  for (const auto* name : {"d.nrrd", "d.mha"}) {
    write_displacement(path(name), field, 0.74, oblique);
    const auto read = read_displacement(path(name));
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(read.placement.origin[i], oblique.origin[i], 1e-12) << name;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(read.placement.axes[axis][i], oblique.axes[axis][i], 1e-12) << name;
      }
    }
    EXPECT_NEAR(read.placement.thickness, 3.0, 1e-12) << name;
    for (std::size_t site = 0; site < field.x.size(); ++site) {
      EXPECT_NEAR(read.pixels.x[site], field.x[site], 1e-4) << name;
      EXPECT_NEAR(read.pixels.y[site], field.y[site], 1e-4) << name;
    }
  }
  const auto sheared = write_nrrd("s.nrrd", "float", "2 2", "1 2 3 4",
                                  "space dimension: 2\nspace directions: (1,0) (0.6,0.8)\n");
  expect_refusal([&] { (void)read_scalar(sheared); }, "not perpendicular");
}

TEST_F(ImageFiles, WhatCannotBeWrittenLeavesNothing) {
  const VectorField field({3, 3});
  const ScalarField picture({3, 3});
  expect_refusal([&] { write_displacement(path("d.vtk"), field, 1.0); }, ".nrrd or .mha");
  expect_refusal([&] { write_png(path("p.jpg"), picture); }, ".png");
  expect_refusal([&] { write_magnitude_png(path("p"), field, 1.0); }, ".png");
  expect_refusal([&] { write_displacement(path("gone") / "d.nrrd", field, 1.0); }, "does not exist");
  expect_refusal([&] { write_displacement(path("d.nrrd"), field, 0.0); }, "0 mm");
  VectorField infinite = field;
  infinite.y[4] = std::numeric_limits<float>::infinity();
  expect_refusal([&] { write_displacement(path("d.nrrd"), infinite, 1.0); }, "x = 1, y = 1");
  expect_refusal([&] { write_magnitude_png(path("p.png"), infinite, 1.0); }, "x = 1, y = 1");
  EXPECT_TRUE(files().empty());

  fs::create_directory(path("folder.nrrd"));
  write("folder.nrrd/file", "so that it cannot be replaced");
  expect_refusal([&] { write_displacement(path("folder.nrrd"), field, 1.0); }, "is a folder");
  EXPECT_EQ(files(), std::vector<std::string>{"folder.nrrd"});
}

TEST_F(ImageFiles, PicturesAreRoundedAndClamped) {
  ScalarField picture({3, 2});
  picture.values = {-5.0F, 0.4F, 99.6F, 254.6F, 1e9F, std::numeric_limits<float>::quiet_NaN()};
  write_png(path("p.png"), picture);
  write_png(path("p.png"), picture); // over the first
  EXPECT_EQ(read_labels(path("p.png")).pixels.values, (std::vector<int>{0, 0, 100, 255, 255, 0}));
  EXPECT_EQ(files().size(), 1U);
}

TEST_F(ImageFiles, MagnitudesGetBrighterAllTheWay) {
  VectorField field({102, 1});
  for (int x = 0; x < 102; ++x) {
    field.x[static_cast<std::size_t>(x)] = 0.6F * static_cast<float>(x);
    field.y[static_cast<std::size_t>(x)] = -0.8F * static_cast<float>(x);
  }
  write_magnitude_png(path("m.png"), field, 100.0);
  expect_refusal([&] { (void)read_scalar(path("m.png")); }, "3 components");
  const auto red_green = read_vector(path("m.png")).pixels;
  const auto brightness = [&](std::size_t x) { return 0.3F * red_green.x[x] + 0.6F * red_green.y[x]; };
  EXPECT_EQ(brightness(0), 0.0F);
  for (std::size_t x = 1; x <= 100; ++x) {
    EXPECT_GT(brightness(x), brightness(x - 1)) << x;
  }
  EXPECT_GT(brightness(100), 200.0F);
  EXPECT_EQ(brightness(101), brightness(100));
}

/// Slices of a real person in the folder that HDMBENCH_TEST_DATA names.
class RealSlices : public ImageFiles {
protected:
  void SetUp() override {
    ImageFiles::SetUp();
    const char* const data = std::getenv("HDMBENCH_TEST_DATA");
    if (IsSkipped()) {
      return;
    }
    if (data == nullptr) {
      GTEST_SKIP() << "HDMBENCH_TEST_DATA is not set";
    }
    labels_ = fs::path(data) / "n2m_axial70_label.nrrd";
    picture_ = fs::path(data) / "n2m_axial85_300_t1.nrrd";
    for (const auto& file : {labels_, picture_}) {
      if (!fs::exists(file)) {
        GTEST_SKIP() << file << " is not there";
      }
    }
  }
  fs::path labels_;
  fs::path picture_;
};

TEST_F(RealSlices, AreRead) {
  const auto labels = read_labels(labels_);
  EXPECT_EQ(labels.pixels.extent, (Extent{192, 192}));
  EXPECT_EQ(labels.spacing, 1.0);
  EXPECT_EQ(std::set<int>(labels.pixels.values.begin(), labels.pixels.values.end()),
            (std::set<int>{0, 1, 2, 3}));
  const auto picture = read_scalar(picture_);
  EXPECT_EQ(picture.pixels.extent, (Extent{300, 300}));
  EXPECT_NEAR(picture.spacing, 0.5933, 1e-4);
  const auto small = read_labels(labels_, {.slice = {}, .size = Extent{64, 64}});
  EXPECT_EQ(small.spacing, 3.0);
  EXPECT_EQ(std::set<int>(small.pixels.values.begin(), small.pixels.values.end()),
            (std::set<int>{0, 1, 2, 3}));
}

TEST_F(RealSlices, CutShortAreRefused) {
  for (const auto& whole : {labels_, picture_}) {
    const auto file = cut(whole, 0.5, "cut.nrrd");
    expect_refusal([&] { (void)read_scalar(file); }, "fread got only");
  }
}

TEST(MissingImages, SayHowToGetThem) {
  if (have_images()) {
    GTEST_SKIP() << "built with ITK";
  }
  const VectorField field({2, 2});
  const std::vector<std::function<void()>> calls{
      [] { (void)read_labels("a.nrrd"); },
      [] { (void)read_scalar("a.nrrd"); },
      [] { (void)read_vector("a.nrrd"); },
      [] {
        (void)read_brain("a.nrrd", 0, 3, 0.1, {2, 2});
      },
      [&] { write_displacement("a.nrrd", field, 1.0); },
      [] {
        write_png("a.nrrd", ScalarField({2, 2}));
      },
      [&] { write_magnitude_png("a.nrrd", field, 1.0); },
  };
  for (const auto& call : calls) {
    expect_refusal(call, "-DHDMBENCH_IMAGES=ON");
    expect_refusal(call, "a.nrrd");
  }
}

} // namespace
} // namespace hdmbench
