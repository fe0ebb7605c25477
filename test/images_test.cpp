// Image files: what is read is what they hold, what is written comes back, what is damaged is refused with
// its name, and scenes are made of them.

#include "harness/scene/scene.hpp"
#include "test/files.hpp"

#include <gmock/gmock.h>
#include <toml++/toml.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>
#include <utility>

namespace hdmbench {
namespace {

constexpr std::string_view vector_kind = "kinds: vector domain domain\n";

TEST_F(ImageFiles, ScalarsComeAsTheyAre) {
  const auto image =
      read_scalar(write_nrrd("a.nrrd", "float", "3 2", "1 -2.5 nan 1e30 inf 0", "spacings: 0.5 0.5\n"));
  EXPECT_EQ(image.pixels.extent, (Extent{3, 2}));
  EXPECT_EQ(image.spacing, 0.5);
  std::vector<float> values = image.pixels.values;
  EXPECT_TRUE(std::isnan(std::exchange(values[2], 0.0F)));
  EXPECT_EQ(values, (std::vector<float>{1.0F, -2.5F, 0.0F, 1e30F, HUGE_VALF, 0.0F}));
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
  for (const auto& [sizes, pixels] : {std::pair{"2 2 1", "1 2 3 4"}, std::pair{"3 2 1", "1 2 9 3 4 9"}}) {
    const auto field = read_vector(write_nrrd("v.nrrd", "float", sizes, pixels, vector_kind)).pixels;
    EXPECT_EQ(field.extent, (Extent{2, 1}));
    EXPECT_EQ(field[0], (std::vector<float>{1, 3}));
    EXPECT_EQ(field[1], (std::vector<float>{2, 4}));
  }
  const auto vectors = write_nrrd("v.nrrd", "float", "2 2 1", "1 2 3 4", vector_kind);
  expect_refusal([&] { (void)read_scalar(vectors); }, "2 components");
  expect_refusal([&] { (void)read_labels(vectors); }, "2 components");
  const auto four = write_nrrd("4.nrrd", "float", "4 1 1", "1 2 3 4", vector_kind);
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
}

TEST_F(ImageFiles, OblongPixelsBecomeSquares) {
  const auto image = write_nrrd("a.nrrd", "uchar", "2 1", "1 2", "spacings: 1 2\n");
  const auto labels = read_labels(image);
  EXPECT_EQ(labels.pixels.extent, Extent(2, 2));
  EXPECT_EQ(labels.pixels.values, (std::vector{1, 2, 1, 2}));
  EXPECT_EQ(labels.spacing, 1.0);
  EXPECT_EQ(labels.placement.origin, (Placement::Vector{0.0, -0.5, 0.0}));
  EXPECT_EQ(sides_text(*labels.oblong), "1 mm x 2 mm");
  EXPECT_FALSE(labels.padded);
  const auto stated = read_labels(image, {.spacing = 3.0});
  EXPECT_EQ(stated.pixels.values, (std::vector{1, 2}));
  EXPECT_EQ(stated.spacing, 3.0);
  EXPECT_FALSE(stated.oblong);
  // Shortest sides that do not fill a pixel of the border are left out, half of them on each side.
  const auto volume =
      write_nrrd("v.nrrd", "float", "3 2 2", "0 1 2 0 1 2 3 4 5 3 4 5", "spacings: 2 2.25 4.5\n");
  const auto cubes = read_scalar(volume, {.takes_volumes = true});
  EXPECT_EQ(cubes.pixels.extent, Extent(3, 2, 4));
  EXPECT_EQ(sides_text(*cubes.oblong), "2 mm x 2.25 mm x 4.5 mm");
  EXPECT_THAT(cubes.placement.origin,
              testing::ElementsAre(0.0, testing::DoubleEq(0.125), testing::DoubleEq(-0.75)));
  EXPECT_FLOAT_EQ(cubes.pixels.values[cubes.pixels.extent.index(1, 1, 1)], 1.0F + 3.0F * (1.25F / 4.5F));
  // A displacement has the same millimetres on any grid.
  const auto field =
      write_nrrd("d.nrrd", "float", "3 2 2 2", "1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3",
                 "kinds: vector domain domain domain\nspacings: nan 2 2 4\n");
  const auto displacement = read_displacement(field, true);
  EXPECT_EQ(displacement.pixels.extent, Extent(2, 2, 4));
  EXPECT_EQ(displacement.pixels[2], std::vector<float>(16, 1.5F));
  // It is written on the grid of the oblong voxels again.
  VectorField sloped(cubes.pixels.extent);
  for_each_site(sloped.extent, [&](int x, int y, int z) {
    sloped[2][sloped.extent.index(x, y, z)] = static_cast<float>(z) + 0.5F;
  });
  write_displacement(path("w.nrrd"), sloped, cubes.spacing, cubes.placement, cubes.oblong);
  const auto written = read_vector(path("w.nrrd"), {.spacing = 1.0, .takes_volumes = true});
  EXPECT_EQ(written.pixels.extent, Extent(3, 2, 2));
  EXPECT_EQ(written.placement.origin, (Placement::Vector{0.0, 0.0, 0.0}));
  EXPECT_THAT(content(path("w.nrrd")), HasSubstr("(2,0,0) (0,2.25,0) (0,0,4.5)"));
  for (std::size_t site = 0; site < 12; ++site) { // the first slice lies 0.75 mm above the first cubes
    EXPECT_FLOAT_EQ(written.pixels[2][site], 2.0F * (0.5F + (site < 6 ? 0.375F : 0.375F + 2.25F)));
  }
  const auto flat = write_nrrd("f.nrrd", "uchar", "2 2 2", "1 2 3 4 5 6 7 8", "spacings: 1e-4 1e-4 1e5\n");
  expect_refusal(
      [&] { (void)read_labels(flat, {.takes_volumes = true}); },
      "its pixels are 0.0001 mm x 0.0001 mm x 100000 mm, and 8e+09 of the shortest side would fill");
}

TEST_F(ImageFiles, PixelsMustBeUpright) {
  const auto sheared = write_nrrd("s.nrrd", "float", "2 2", "1 2 3 4",
                                  "space dimension: 2\nspace directions: (1,0) (0.6,0.8)\n");
  expect_refusal([&] { (void)read_scalar(sheared); }, "not perpendicular");
}

/// Of an image and of a volume, which lie anywhere in space; NIfTI has the place as floats.
TEST_F(ImageFiles, FieldsComeBackWithTheirPlaceFromEveryFormat) {
  const double c = std::cos(0.2);
  const double s = std::sin(0.2);
  for (const Extent extent : {Extent{7, 5}, Extent{4, 3, 2}}) {
    const Placement oblique{.origin = {-70.0, 33.0, 5.5},
                            .axes = {{{c, 0.0, s}, {0.0, -1.0, 0.0}, {s, 0.0, -c}}},
                            .thickness = extent.depth > 1 ? 0.0 : 3.0};
    VectorField field = some_displacement(extent);
    LabelField labels{extent, std::vector<int>(extent.sites())};
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      labels.values[site] = static_cast<int>(site);
      if (extent.depth > 1) {
        field[2][site] = field[0][site] - 2.0F * field[1][site];
      }
    }
    for (const std::string name : {"d.nrrd", "d.mha", "d.nii.gz"}) {
      if (name == "d.nii.gz" && extent.depth == 1) {
        continue; // of one slice ITK reads the place in the plane only
      }
      SCOPED_TRACE(name + " " + extent.text());
      const double rounding = name == "d.nii.gz" ? 1e-5 : 1e-12;
      write_vector(path(name), field, 0.74, oblique);
      EXPECT_EQ(read_vector(path(name), {.takes_volumes = true}).pixels.planes, field.planes);
      write_labels(path(name), labels, 0.74, oblique);
      EXPECT_EQ(read_labels(path(name), {.takes_volumes = true}).pixels.values, labels.values);
      if (extent.depth > 1) {
        expect_refusal([&] { (void)read_labels(path(name)); }, "choose one of its slices 0 ... 1");
      }
      write_displacement(path(name), field, 0.74, oblique);
      // Millimetres along the space's axes, against the second of which the rows follow each other.
      const auto stored = read_vector(path(name), {.takes_volumes = true});
      EXPECT_FLOAT_EQ(stored.pixels[1][7], -0.74F * field[1][7]);
      const auto read = read_displacement(path(name), true);
      EXPECT_NEAR(read.spacing, 0.74, rounding);
      EXPECT_NEAR(read.placement.thickness, oblique.thickness, rounding);
      ASSERT_EQ(read.pixels.extent, extent);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(read.placement.origin[axis], oblique.origin[axis], rounding);
        for (std::size_t i = 0; i < 3; ++i) {
          EXPECT_NEAR(read.placement.axes[axis][i], oblique.axes[axis][i], rounding);
        }
        for (std::size_t site = 0; axis < extent.axes() && site < extent.sites(); ++site) {
          EXPECT_NEAR(read.pixels[axis][site], field[axis][site], 2e-4);
        }
      }
    }
  }
  EXPECT_THAT(content(path("d.nrrd")),
              AllOf(HasSubstr("\nhdmbench mapping:=forward: tissue at x moves to x + d(x)\n"),
                    HasSubstr("\nhdmbench unit:=millimetre\n"), HasSubstr("\nsizes: 3 4 3 2\n")));
  EXPECT_THAT(content(path("d.mha")),
              AllOf(HasSubstr("\nhdmbench mapping = forward: tissue at x moves to x + d(x)\n"),
                    HasSubstr("\nDimSize = 4 3 2\n")));
  EXPECT_EQ(files().size(), 3U);
}

/// Devices differ in the sign of 0, and files are compared byte by byte.
TEST_F(ImageFiles, ZerosArePositive) {
  for (const Extent extent : {Extent{3, 2}, Extent{3, 2, 2}}) {
    VectorField field = some_displacement(extent);
    field[0][1] = 0.0F;
    write_displacement(path("plus.nrrd"), field, 0.5);
    field[0][1] = std::bit_cast<float>(0x80000000U);
    write_displacement(path("minus.nrrd"), field, 0.5);
    EXPECT_EQ(content(path("minus.nrrd")), content(path("plus.nrrd")));
  }
}

TEST_F(ImageFiles, VolumesAreResampledAndRefused) {
  const auto read = [](const fs::path& file, std::optional<Extent> size = {}) {
    return read_labels(file, {.size = size, .takes_volumes = true});
  };
  const auto file = write_nrrd("a.nrrd", "uchar", "2 2 2", "1 2 3 4 5 6 7 8");
  const auto doubled = read(file, Extent{4, 4, 8});
  EXPECT_EQ(doubled.spacing, 0.5);
  EXPECT_TRUE(doubled.padded);
  EXPECT_EQ(doubled.placement.origin, (Placement::Vector{-0.25, -0.25, -1.25}));
  for_each_site({4, 4, 8}, [&](int x, int y, int z) {
    const int label = z < 2 || z > 5 ? 0 : 1 + x / 2 + 2 * (y / 2) + 4 * ((z - 2) / 2);
    EXPECT_EQ(doubled.pixels.values[doubled.pixels.extent.index(x, y, z)], label) << x << y << z;
  });
  EXPECT_EQ(read_scalar(file, {.size = Extent{3, 3, 3}, .takes_volumes = true}).pixels.values[13], 4.5F);
  expect_refusal([&] { (void)read(file, Extent{4, 4}); }, "it is a volume, and cannot be resampled to 4 x 4");
  const auto flat = write_nrrd("flat.nrrd", "uchar", "2 2", "1 2 3 4");
  expect_refusal([&] { (void)read(flat, Extent{4, 4, 4}); }, "it has one slice");
  const auto thin = write_nrrd("thin.nrrd", "uchar", "1 2 2", "1 2 3 4");
  expect_refusal([&] { (void)read(thin); }, "each side must be at least 2");
  const auto with = [&](std::string_view header) {
    return write_nrrd("b.nrrd", "uchar", "2 2 2", "1 2 3 4 5 6 7 8", std::string(header));
  };
  expect_refusal(
      [&] { (void)read(with("space dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0.6,0.8)\n")); },
      "no rotation: the product of axes 2 and 3 is 0.6");
  const auto pairs = write_nrrd("p.nrrd", "float", "2 2 2 2", "1 2 3 4 5 6 7 8 1 2 3 4 5 6 7 8",
                                "kinds: vector domain domain domain\n");
  expect_refusal([&] { (void)read_vector(pairs, {.takes_volumes = true}); }, "2 components per voxel");
}

TEST_F(ImageFiles, WhatCannotBeWrittenLeavesNothing) {
  const VectorField field({3, 3});
  expect_refusal([&] { write_displacement(path("d.vtk"), field, 1.0); }, ".nrrd, .mha or .nii.gz");
  expect_refusal([&] { write_png(path("p.jpg"), ScalarField({3, 3})); }, ".png");
  expect_refusal([&] { write_displacement(path("gone") / "d.nrrd", field, 1.0); }, "does not exist");
  expect_refusal([&] { write_displacement(path("d.nrrd"), field, 0.0); }, "0 mm");
  VectorField infinite = field;
  infinite[1][4] = HUGE_VALF;
  expect_refusal([&] { write_displacement(path("d.nrrd"), infinite, 1.0); }, "x = 1, y = 1");
  expect_refusal([&] { write_magnitude_png(path("p.png"), magnitude_of(infinite), 1.0); }, "x = 1, y = 1");
  EXPECT_TRUE(files().empty());
  fs::create_directory(path("folder.nrrd"));
  write("folder.nrrd/file", "so that it cannot be replaced");
  expect_refusal([&] { write_displacement(path("folder.nrrd"), field, 1.0); }, "is a folder");
  EXPECT_EQ(files(), std::vector<std::string>{"folder.nrrd"});
}

TEST_F(ImageFiles, PicturesAreRoundedAndClampedAndMagnitudesGetBrighter) {
  ScalarField picture({3, 2});
  picture.values = {-5.0F, 0.4F, 99.6F, 254.6F, 1e9F, std::numeric_limits<float>::quiet_NaN()};
  write_png(path("p.png"), picture);
  write_png(path("p.png"), picture); // over the first
  EXPECT_EQ(read_labels(path("p.png")).pixels.values, (std::vector<int>{0, 0, 100, 255, 255, 0}));
  EXPECT_EQ(files().size(), 1U);
  VectorField field({102, 1});
  for (std::size_t x = 0; x < 102; ++x) {
    field[0][x] = 0.6F * static_cast<float>(x);
    field[1][x] = -0.8F * static_cast<float>(x);
  }
  write_magnitude_png(path("m.png"), magnitude_of(field), 100.0);
  const auto red_green = read_vector(path("m.png")).pixels;
  const auto brightness = [&](std::size_t x) { return 0.3F * red_green[0][x] + 0.6F * red_green[1][x]; };
  EXPECT_EQ(brightness(0), 0.0F);
  for (std::size_t x = 1; x <= 100; ++x) {
    EXPECT_GT(brightness(x), brightness(x - 1)) << x;
  }
  EXPECT_EQ(brightness(101), brightness(100));
}

// ---- Damage

TEST_F(ImageFiles, WhatIsNoImageIsRefused) {
  expect_refusal([&] { (void)read_scalar(path("gone.png")); }, "there is no such file");
  expect_refusal([&] { (void)read_scalar(path("")); }, "it is a folder");
  for (const auto* name : {"a.png", "a.nrrd", "a.nii", "a.nii.gz", "a.mha", "a.jpg", "a.tif", "a"}) {
    for (const auto* text : {"This is no image.\n", ""}) {
      const auto file = write(name, text);
      expect_refusal([&] { (void)read_scalar(file); }, file.string());
      expect_refusal([&] { (void)read_scalar(file); }, "NRRD, MetaImage, NIfTI, PNG, JPEG or TIFF");
    }
  }
}

const toml::table& damaged() {
  static const toml::table file = toml::parse_file(HDMBENCH_DAMAGED_IMAGES ".toml");
  return file;
}

TEST_F(ImageFiles, CutShortOrDamagedTheyAreRefused) {
  for (const char* name :
       {"grey.jpg", "grey.png", "grey.tif", "short.nii", "raw.nrrd", "raw.mha", "compressed.mha"}) {
    const std::string whole = content(fs::path(HDMBENCH_DAMAGED_IMAGES) / name);
    for (std::size_t length = 1; length<whole.size(); length += whole.size() - length> 40 ? 30 : 1) {
      const auto file = write(name, std::string_view(whole).substr(0, length));
      expect_refusal([&] { (void)read_scalar(file); }, file.string());
    }
  }
  std::string bytes = content(fs::path(HDMBENCH_DAMAGED_IMAGES) / "grey.png");
  bytes[18] = '\x7f'; // a digit of the width, so that the header's checksum is wrong
  const auto header = write("damaged.png", bytes);
  expect_refusal([&] { (void)read_scalar(header); }, "IHDR: CRC error");
  bytes = content(fs::path(HDMBENCH_DAMAGED_IMAGES) / "compressed.mha");
  bytes[bytes.size() - 9] = static_cast<char>(~bytes[bytes.size() - 9]);
  const auto pixels = write("damaged.mha", bytes);
  expect_refusal([&] { (void)read_vector(pixels); }, "damaged");
  for (const auto& row : *damaged()["texts"].as_array()) {
    const auto text = [&](std::size_t i) { return (*row.as_array())[i].value<std::string>().value(); };
    SCOPED_TRACE(text(1));
    const auto file = write(text(0), text(1));
    expect_refusal([&] { (void)read_scalar(file); }, text(2));
  }
}

TEST_F(ImageFiles, OnWhichItkFailsAreRefusedAndOthersAreRead) {
  const toml::table& refusals = *damaged()["refused"].as_table();
  int count = 0;
  for (const auto& entry : fs::directory_iterator(HDMBENCH_DAMAGED_IMAGES)) {
    const fs::path& file = entry.path();
    SCOPED_TRACE(file);
    if (const auto part = refusals[file.filename().string()].value<std::string>()) {
      const std::string says = test::refusal([&] { (void)read_scalar(file); });
      EXPECT_THAT(says, AllOf(HasSubstr(file.string()), HasSubstr(*part), testing::Not(HasSubstr("\n"))));
    } else {
      EXPECT_GT(read_scalar(file).pixels.values.size(), 0U);
    }
    ++count;
  }
  EXPECT_EQ(count, 28);
  const auto values = [](const char* name) {
    return read_scalar(fs::path(HDMBENCH_DAMAGED_IMAGES) / name).pixels.values;
  };
  EXPECT_EQ(values("short.nii"), (std::vector<float>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(values("grey.jpg"), std::vector<float>(64, 100.0F));
}

// ---- Scenes of images

class ImageScene : public ImageFiles {
protected:
  Scene load(std::string_view text, const SceneOptions& options = {}) {
    write_nrrd("labels.nrrd", "short", "3 2", "0 7 7 0 0 7", "spacings: 0.5 0.5\n");
    return load_scene(write("scene.toml", text).string(), options);
  }

  static constexpr std::string_view labelled = "[[tissue]]\nlabel = 0\nmodulus = 10.0\ngray = 5\n[[tissue]]\n"
                                               "label = 7\nmodulus = 30.0\ngray = 50\n[image]\n"
                                               "labels = \"labels.nrrd\"\n";
};

TEST_F(ImageScene, LabelsBecomeModuli) {
  const Scene scene = load(labelled);
  EXPECT_EQ(scene.extent(), (Extent{3, 2}));
  EXPECT_EQ(scene.spacing, 0.5);
  EXPECT_EQ(scene.full.modulus.values, (std::vector<float>{10, 30, 30, 10, 10, 30}));
  EXPECT_EQ(scene.full.inverse_modulus.values[1], 1.0F / 30.0F);
  EXPECT_EQ(scene.picture.values, (std::vector<float>{5, 50, 50, 5, 5, 50}));
  EXPECT_EQ(files_of_scene(path("scene.toml").string()),
            (std::vector<fs::path>{path("scene.toml"), path("labels.nrrd")}));
}

TEST_F(ImageScene, ModuliTargetsAndConfidencesComeFromImagesAndThenFromConditions) {
  write_nrrd("modulus.nrrd", "float", "3 2", "1 2 3 4 5 6.5");
  write_nrrd("target.nrrd", "float", "2 3 2", "1 2 3 4 5 6 7 8 9 10 11 12", vector_kind);
  write_nrrd("confidence.nrrd", "float", "2 3 2", "0 1 0.5 0 0 0 0 0 0 0 1 0.25", vector_kind);
  const Scene scene = load("[image]\nmodulus = \"modulus.nrrd\"\ntarget = \"target.nrrd\"\n"
                           "confidence = \"confidence.nrrd\"\n[[condition]]\nwhere = \"left\"\ndy = -4.0\n");
  EXPECT_EQ(scene.full.modulus.values, (std::vector<float>{1, 2, 3, 4, 5, 6.5}));
  EXPECT_EQ(scene.full.target[0], (std::vector<float>{1, 3, 5, 7, 9, 11}));
  EXPECT_EQ(scene.full.target[1], (std::vector<float>{-4, 4, 6, -4, 10, 12}));
  EXPECT_EQ(scene.full.confidence[0], (std::vector<float>{0, 0.5, 0, 0, 0, 1}));
  EXPECT_EQ(scene.full.confidence[1], (std::vector<float>{1, 0, 0, 1, 0, 0.25}));
}

TEST_F(ImageScene, AreVolumesWhereTheirFilesAre) {
  std::string text(labelled);
  text +=
      "target = \"target.nrrd\"\nconfidence = \"target.nrrd\"\n[[condition]]\nwhere = \"back\"\ndz = 3.0\n";
  write_nrrd("volume.nrrd", "short", "2 2 2", "0 7 7 0 0 7 7 7");
  const auto write_target = [&](const char* sizes, const char* pixels) {
    write_nrrd("target.nrrd", "float", sizes, pixels, "kinds: vector domain domain domain\n");
  };
  write_target("3 2 2 2", "0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 1 1");
  text.replace(text.find("labels.nrrd"), 6, "volume");
  const Scene scene = load(text);
  EXPECT_EQ(scene.extent(), (Extent{2, 2, 2}));
  EXPECT_EQ(scene.full.target[2], (std::vector<float>{1, 1, 1, 1, 3, 3, 3, 3}));
  EXPECT_EQ(scene.full.target[1].back(), 1.0F);
  EXPECT_EQ(scene.full.modulus.values, (std::vector<float>{10, 30, 30, 10, 10, 30, 30, 30}));
  write_target("3 2 2 3", "0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 1 1 0 0 0 0 0 0 0 0 0 0 0 0");
  expect_refusal([&] { (void)load(text); }, "target is 2 x 2 x 3, the scene is 2 x 2 x 2");
}

TEST_F(ImageScene, SizeResamplesAndSpacingIsThatOfTheFilesPixels) {
  const Scene scene = load(labelled, {.size = Extent{30, 20}});
  EXPECT_EQ(scene.extent(), (Extent{30, 20}));
  EXPECT_NEAR(scene.spacing, 0.05, 1e-12);
  // The corner of the image stays where it is: half a pixel before the first pixel's centre.
  EXPECT_NEAR(scene.placement.origin[0] - 0.5 * 0.05, -0.5 * 0.5, 1e-12);
  EXPECT_NEAR(scene.placement.origin[1] - 0.5 * 0.05, -0.5 * 0.5, 1e-12);
  EXPECT_EQ(scene.full.modulus.values[0], 10.0F);
  EXPECT_EQ(scene.full.modulus.values[29], 30.0F);
  const Scene halved = load(fmt::format("spacing = 2.0\n{}", labelled), {.size = Extent{6, 4}});
  EXPECT_EQ(halved.spacing, 1.0);
  EXPECT_EQ(halved.placement.origin, (Placement::Vector{-0.5, -0.5, 0.0}));
  EXPECT_FALSE(halved.oblong);
  std::string text(labelled);
  text.replace(text.find("labels.nrrd"), 6, "oblong");
  write_nrrd("oblong.nrrd", "short", "3 1", "0 7 7", "spacings: 0.5 1\n");
  const Scene oblong = load(text);
  EXPECT_EQ(oblong.extent(), (Extent{3, 2}));
  EXPECT_EQ(oblong.spacing, 0.5);
  EXPECT_EQ(sides_text(*oblong.oblong), "0.5 mm x 1 mm");
}

/// Slices of a real person, in the folder that HDMBENCH_TEST_DATA names.
TEST_F(ImageFiles, RealSlicesAreRead) {
  const char* const data = std::getenv("HDMBENCH_TEST_DATA");
  if (data == nullptr) {
    GTEST_SKIP() << "HDMBENCH_TEST_DATA is not set";
  }
  const auto labels = read_labels(fs::path(data) / "n2m_axial70_label.nrrd");
  EXPECT_EQ(labels.pixels.extent, (Extent{192, 192}));
  EXPECT_EQ(labels.spacing, 1.0);
  const auto& values = labels.pixels.values;
  EXPECT_EQ(std::set<int>(values.begin(), values.end()), (std::set<int>{0, 1, 2, 3}));
  const auto picture = read_scalar(fs::path(data) / "n2m_axial85_300_t1.nrrd");
  EXPECT_EQ(picture.pixels.extent, (Extent{300, 300}));
  EXPECT_NEAR(picture.spacing, 0.5933, 1e-4);
}

} // namespace
} // namespace hdmbench
