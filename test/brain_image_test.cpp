#include "harness/scene/scene.hpp"
#include "harness/scene/sites.hpp"
#include "test/files.hpp"

namespace hdmbench {
namespace {

TEST_F(ImageFiles, EveryOrientationIsTurnedByItsHeader) {
  // Brighter to the right (x), in front (y) and above (z): positive axes of the file point there.
  std::string voxels;
  for (int z = 0; z < 4; ++z) {
    for (int y = 0; y < 6; ++y) {
      for (int x = 0; x < 5; ++x) {
        voxels += fmt::format("{} ", 1 + x + 10 * y + 100 * z);
      }
    }
  }
  const auto file = write_nrrd("turned.nrrd", "float", "5 6 4", voxels,
                               "space: right-anterior-superior\nspace directions: (2,0,0) (0,2,0) (0,0,2)\n"
                               "space origin: (0,0,0)\n");
  const auto axial = read_brain(file, 1, 2, 0.0, {5, 6});                         // the second from below
  const auto coronal = read_brain(file, 1, 1, 0.0, {5, 4}, Orientation::coronal); // the second from the front
  const auto sagittal = read_brain(file, 1, 1, 0.0, {6, 4}, Orientation::sagittal); // ... from the right
  for (int row = 0; row < 6; ++row) {
    for (int x = 0; x < 5; ++x) {
      EXPECT_NEAR(axial.picture.values[axial.picture.extent.index(x, row)],
                  255.0 * (1 + (4 - x) + 10 * (5 - row) + 100) / 155.0, 0.01);
    }
  }
  EXPECT_EQ(axial.tissue.values.front(), 2);
  EXPECT_EQ(axial.tissue.values.back(), 1);
  for (int row = 0; row < 4; ++row) {
    for (int x = 0; x < 5; ++x) {
      const double stored = 1 + (4 - x) + 10 * 4 + 100 * (3 - row);
      EXPECT_NEAR(coronal.picture.values[coronal.picture.extent.index(x, row)], 255.0 * stored / 345.0, 0.01);
    }
    for (int x = 0; x < 6; ++x) {
      const double stored = 1 + 3 + 10 * (5 - x) + 100 * (3 - row);
      EXPECT_NEAR(sagittal.picture.values[sagittal.picture.extent.index(x, row)], 255.0 * stored / 354.0,
                  0.01);
    }
  }
  using Vector = Placement::Vector; // to the left, to the back, upwards: the file has the opposite of two
  EXPECT_EQ(coronal.placement.origin, (Vector{-8.0, -8.0, 6.0}));
  EXPECT_EQ(coronal.placement.axes, (std::array{Vector{1, 0, 0}, Vector{0, 0, -1}, Vector{0, 1, 0}}));
  EXPECT_EQ(sagittal.placement.origin, (Vector{-6.0, -10.0, 6.0}));
  EXPECT_EQ(sagittal.placement.axes, (std::array{Vector{0, 1, 0}, Vector{0, 0, -1}, Vector{1, 0, 0}}));
  EXPECT_EQ(sagittal.placement.thickness, 2.0);
  expect_refusal(
      [&] {
        (void)read_brain(file, 6, 1, 0.0, {5, 4}, Orientation::coronal);
      },
      "no coronal slice 6, it has the slices 0 ... 5 from the front");
  expect_refusal(
      [&] {
        (void)read_brain(file, -1, 1, 0.0, {5, 4}, Orientation::sagittal);
      },
      "no sagittal slice -1, it has the slices 0 ... 4 from the patient's right");
}

TEST_F(ImageFiles, BrainIsOnePartWithoutHoles) {
  const auto file = write_nrrd("b.nrrd", "float", "8 5 1",
                               "0 0 0 0 0 0 0 0 "
                               "0 5 5 5 0 0 0 0 "
                               "0 5 0 9 0 0 7 0 "
                               "0 5 5 9 0 0 0 0 "
                               "0 0 0 0 0 0 0 0");
  const auto brain = read_brain(file, 0, 2, 0.0, {3, 3});
  EXPECT_EQ(brain.tissue.values, (std::vector<int>{1, 1, 1, 1, 1, 2, 1, 1, 2}));
  EXPECT_EQ(brain.picture.values[4], 0.0F);
  const auto flat = write_nrrd("flat.nrrd", "float", "2 2 1", "3 3 3 3");
  EXPECT_EQ(read_brain(flat, 0, 3, 0.0, {2, 2}).tissue.values, (std::vector<int>{1, 1, 1, 1}));
  const auto broken = write_nrrd("nan.nrrd", "float", "2 2 1", "3 nan 3 3");
  expect_refusal([&] { (void)read_brain(broken, 0, 3, 0.0, {2, 2}); }, "not finite");
  const auto vectors = write_nrrd("v.nrrd", "float", "2 2 1", "1 2 3 4", "kinds: vector domain domain\n");
  expect_refusal([&] { (void)read_brain(vectors, 0, 3, 0.0, {2, 2}); }, "2 components");
}

TEST_F(ImageFiles, WithoutASliceItIsTheOneThatShowsMostOfTheBrain) {
  const auto file = write_nrrd("most.nrrd", "float", "3 3 3",
                               "0 0 0 0 5 0 0 0 0 "
                               "0 0 0 5 9 5 5 9 5 "
                               "5 9 0 0 0 0 0 0 0");
  const BrainSlice found = read_brain(file, std::nullopt, 2, 0.0, {6, 6});
  EXPECT_EQ(found.picture.values, read_brain(file, 1, 2, 0.0, {6, 6}).picture.values);
  EXPECT_NE(found.picture.values, read_brain(file, 2, 2, 0.0, {6, 6}).picture.values);
}

TEST_F(ImageFiles, BrainAndHeadLieAtOnePlace) {
  const auto volume = [&](const char* name, const char* origin) {
    return write_nrrd(
        name, "float", "3 3 3", "0 0 0 0 5 0 0 0 0 0 0 0 5 9 5 5 9 5 5 9 0 0 0 0 0 0 0",
        fmt::format("space dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: {}\n",
                    origin));
  };
  const auto brain = volume("brain.nrrd", "(0,0,0)");
  EXPECT_EQ(read_head(brain, volume("near.nrrd", "(0,0.0001,0)"), 2, 0.0, {}).picture.extent,
            (Extent{3, 3, 3}));
  expect_refusal([&] { (void)read_head(brain, volume("far.nrrd", "(0,0.01,0)"), 2, 0.0, {}); },
                 "lies elsewhere");
}

TEST_F(ImageFiles, WhatLiesBetweenFoldsOfABrainIsLiquid) {
  const auto volume = [&](const char* name, auto&& value) {
    std::string text;
    for_each_site(Extent{9, 7, 5}, [&](int x, int y, int z) { text += value(x, y, z) ? "5 " : "0 "; });
    return write_nrrd(
        name, "float", "9 7 5", text,
        "space dimension: 3\nspace directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (0,0,0)\n");
  };
  // A furrow of one voxel, which is 2 mm, open to one side.
  const auto in_brain = [](int x, int y, int /*z*/) { return x > 1 && x < 7 && !(x == 4 && y < 4); };
  const auto brain = volume("brain.nrrd", in_brain);
  const auto head = volume("head.nrrd", [](int x, int /*y*/, int /*z*/) { return x > 0; });
  const auto label_in = [&](double sulci) {
    return read_head(brain, head, 1, sulci, {}).tissue.values[Extent{9, 7, 5}.index(4, 2, 2)];
  };
  EXPECT_EQ(label_in(0.0), 2);
  EXPECT_EQ(label_in(2.0), 2) << "its sides are 4 mm from each other, by the centres of voxels";
  EXPECT_EQ(label_in(4.1), 1);
}

/// Colin27 without skull, of the Debian package mricron-data.
class Colin : public ImageFiles {
protected:
  void SetUp() override {
    ImageFiles::SetUp();
    if (!IsSkipped() && !fs::exists(file_)) {
      GTEST_SKIP() << file_ << " is not there: install mricron-data";
    }
  }
  [[nodiscard]] BrainSlice brain(Extent size, int classes = 3) const {
    return read_brain(file_, slice_, classes, margin_, size);
  }

  const fs::path file_ = "/usr/share/mricron/templates/ch2bet.nii.gz";
  static constexpr int slice_ = 76;
  static constexpr double margin_ = 0.1;
};

TEST_F(Colin, SinksUnderAnOpeningOfTheSkullThatHoldsTheRest) {
  for (const std::optional<Extent> size : {std::optional<Extent>(), std::optional(Extent{46, 55, 46})}) {
    const Scene head = load_scene("head", {.size = size});
    const Level& full = head.full;
    const Extent extent = size.value_or(Extent{181, 217, 181});
    ASSERT_EQ(full.extent, extent);
    const double spacing = std::max(181.0 / extent.width, 217.0 / extent.height);
    EXPECT_NEAR(head.spacing, spacing, 1e-12);
    const double first = 0.5 * (181.0 - 1.0 - spacing * (extent.width - 1)); // from the file's first voxel
    EXPECT_EQ(head.placement.axes[0], (Placement::Vector{-1.0, 0.0, 0.0}));
    EXPECT_NEAR(head.placement.origin[0], 90.0 - first, 1e-6);
    std::array<double, 5> share{};
    double sunk = 0.0;
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      const int label = head.labels.values[site];
      share.at(static_cast<std::size_t>(label)) += 1.0 / static_cast<double>(extent.sites());
      const float held = label == 0 || label == 4 ? 1.0F : 0.0F;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(full.confidence[axis][site], held) << label;
        ASSERT_TRUE(axis == 2 || full.target[axis][site] == 0.0F);
      }
      sunk = std::min(sunk, head.spacing * double{full.target[2][site]});
      ASSERT_LE(full.target[2][site], 0.0F);
    }
    EXPECT_GE(sunk, -10.0);
    EXPECT_LT(sunk, size ? -9.0 : -9.9);
    const std::array<double, 5> expected{0.4, 0.03, 0.12, 0.09, 0.35};
    for (std::size_t label = 0; label < share.size(); ++label) {
      EXPECT_NEAR(share.at(label), expected.at(label), 0.06) << label;
    }
  }
}

/// Golden hashes hold the shipped one.
TEST_F(Colin, IsASceneWithItsSliceClassesAndMargin) {
  const Extent size{100, 80};
  const auto other =
      write("other.toml", fmt::format("size = [100, 80]\n[brain]\nfile = \"{}\"\nslice = 90\nclasses = 1\n"
                                      "margin = 0.3\n[[tissue]]\nlabel = 0\nmodulus = 1.0\n"
                                      "[[tissue]]\nlabel = 1\nmodulus = 2.0\n",
                                      file_.string()));
  EXPECT_EQ(load_scene(other.string()).labels.values, read_brain(file_, 90, 1, 0.3, size).tissue.values);
}

TEST_F(Colin, FitsEverySize) {
  for (const Extent size : {Extent{1, 1}, Extent{2, 2}, Extent{1, 9}, Extent{9, 1}, Extent{3, 3},
                            Extent{16, 16}, Extent{17, 31}, Extent{1200, 1200}}) {
    const auto slice = brain(size);
    EXPECT_EQ(slice.tissue.values.size(), size.sites());
    EXPECT_GT(std::ranges::max(slice.tissue.values), 0);
    EXPECT_LE(std::ranges::max(slice.tissue.values), 3);
    EXPECT_GT(slice.spacing, 0.0);
  }
  EXPECT_NEAR(brain({300, 300}).spacing, 4.0 * brain({1200, 1200}).spacing, 1e-6);
}

TEST_F(Colin, RefusesWhatItCannotDo) {
  const auto refused = [this](int slice, int classes, double margin, Extent size, std::string_view words) {
    expect_refusal([&] { (void)read_brain(file_, slice, classes, margin, size); }, words);
  };
  refused(181, 3, 0.1, {10, 10}, "slices 0 ... 180");
  refused(-1, 3, 0.1, {10, 10}, "slices 0 ... 180");
  refused(180, 3, 0.1, {10, 10}, "no pixel > 0");
  expect_refusal([&] { (void)read_scalar(file_); }, "3-D");
}

TEST_F(Colin, CutShortIsRefused) {
  for (const double share : {0.999, 0.5, 0.01, 0.00005}) {
    const auto file = cut(file_, share, "cut.nii.gz");
    expect_refusal([&] { (void)read_brain(file, 76, 3, 0.1, {10, 10}); }, file.string());
    expect_refusal([&] { (void)read_scalar(file, {.slice = 10, .size = {}}); }, file.string());
  }
  std::string bytes = content(file_);
  bytes[bytes.size() / 2] = static_cast<char>(~bytes[bytes.size() / 2]);
  const auto damaged = write("damaged.nii.gz", bytes);
  expect_refusal([&] { (void)read_scalar(damaged, {.slice = 10, .size = {}}); }, "damaged");
}

} // namespace
} // namespace hdmbench
