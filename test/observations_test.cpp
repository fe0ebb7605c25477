// Known displacements of images and conditions on their way from the pixels of a file to the sites of a
// scene: none is lost or blurred, whatever the pixels' sides and whatever the size that is asked for.

#include "harness/scene/method.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/methods/solver.hpp"
#include "test/files.hpp"

namespace hdmbench {
namespace {

/// Pixels of a file, and the size that the scene is solved at.
struct Resampled {
  const char* sides;
  Extent extent;
  std::optional<Extent> size{};
};
void PrintTo(const Resampled& row, std::ostream* stream) {
  *stream << row.sides << ", " << row.extent.text() << (row.size ? " to " + row.size->text() : "");
}

class Observations : public ImageFiles, public testing::WithParamInterface<Resampled> {
protected:
  [[nodiscard]] static std::size_t axes() { return GetParam().extent.axes(); }

  /// A vector image whose pixels are `fill` but for some.
  void write_vectors(const char* name, const char* fill,
                     const std::map<std::size_t, const char*>& others) const {
    const Extent extent = GetParam().extent;
    std::string pixels;
    for (std::size_t pixel = 0; pixel < extent.sites(); ++pixel) {
      const auto other = others.find(pixel);
      for (std::size_t axis = 0; axis < axes(); ++axis) {
        pixels += fmt::format("{} ", other == others.end() ? fill : other->second);
      }
    }
    const bool is_volume = axes() == 3;
    write_nrrd(name, "float", fmt::format("{} {}", axes(), extent.text(" ")), pixels,
               fmt::format("kinds: vector domain domain{}\nspacings: nan {}\n", is_volume ? " domain" : "",
                           GetParam().sides));
  }

  [[nodiscard]] Scene load(std::string_view more) const {
    const Extent extent = GetParam().extent;
    std::string labels;
    for (std::size_t pixel = 0; pixel < extent.sites(); ++pixel) {
      labels += "1 ";
    }
    write_nrrd("labels.nrrd", "uchar", extent.text(" "), labels,
               fmt::format("spacings: {}\n", GetParam().sides));
    const auto file = write(
        "scene.toml", fmt::format("energy = \"elastic\"\n[[tissue]]\nlabel = 1\nmodulus = 20.0\n{}"
                                  "[image]\nlabels = \"labels.nrrd\"\n{}",
                                  more.starts_with("[[") ? more : "", more.starts_with("[[") ? "" : more));
    return load_scene(file.string(), {.size = GetParam().size, .as_cubes = true});
  }

  /// A component at a pixel of the file, by linear interpolation between the sites, and whether all of these
  /// are certain.
  struct AtPixel {
    double value = 0.0;
    bool is_certain = true;
  };
  [[nodiscard]] AtPixel at_pixel(const Scene& scene, std::size_t axis, std::array<int, 3> pixel) const {
    const Extent sites = scene.extent();
    const FileGrid grid = scene.oblong.value_or(FileGrid{GetParam().extent});
    const PixelPositions at = positions_of(grid, scene.spacing, scene.placement);
    AtPixel result;
    for (unsigned corner = 0; corner < 8; ++corner) {
      double share = 1.0;
      std::array<int, 3> place{};
      for (std::size_t i = 0; i < axes(); ++i) {
        const double position = std::clamp(at.of(i, pixel.at(i)), 0.0, sites.sides().at(i) - 1.0);
        place.at(i) = std::min(static_cast<int>(position), sites.sides().at(i) - 2) +
                      static_cast<int>(corner >> i & 1U);
        share *= std::max(0.0, 1.0 - std::abs(position - place.at(i)));
      }
      const std::size_t site = sites.index(place[0], place[1], place[2]);
      result.is_certain = result.is_certain && (share <= 0.01 || scene.full.confidence[axis][site] == 1.0F);
      result.value += share * double{scene.full.target[axis][site]};
      corner += corner == 3 && axes() == 2 ? 4 : 0;
    }
    return result;
  }

  [[nodiscard]] static std::size_t middle() {
    const Extent extent = GetParam().extent;
    return extent.index(extent.width / 2, extent.height / 2, extent.depth / 2);
  }
};

TEST_P(Observations, OfCertainPixelsPrescribeTheFieldThere) {
  write_vectors("target.nrrd", "0", {{middle(), "1.75"}});
  write_vectors("deviation.nrrd", "inf", {{middle(), "0"}});
  const Scene scene = load("target = \"target.nrrd\"\ndeviation = \"deviation.nrrd\"\n");
  const Extent extent = GetParam().extent;
  for (std::size_t axis = 0; axis < axes(); ++axis) {
    const AtPixel there = at_pixel(scene, axis, {extent.width / 2, extent.height / 2, extent.depth / 2});
    EXPECT_TRUE(there.is_certain);
    EXPECT_NEAR(there.value, 1.75, 1e-5);
  }
  EXPECT_EQ(scene.observed->given, 1U);
  EXPECT_EQ(scene.observed->acting, 1U);
  EXPECT_EQ(scene.observed->exact, 1U);
  EXPECT_LT(scene.observed->farthest, 1e-5);
}

TEST_P(Observations, KeepTheirWeightAndTheirTargets) {
  const std::size_t last = GetParam().extent.sites() - 1;
  write_vectors("target.nrrd", "0", {{0, "-3"}, {middle(), "1.75"}, {last, "5"}});
  write_vectors("deviation.nrrd", "inf", {{0, "0.5"}, {middle(), "2"}, {last, "30"}});
  const Scene scene = load("target = \"target.nrrd\"\ndeviation = \"deviation.nrrd\"\n");
  for (std::size_t axis = 0; axis < axes(); ++axis) {
    double weight = 0.0;
    double weighted = 0.0;
    for (std::size_t site = 0; site < scene.extent().sites(); ++site) {
      const double confidence = double{scene.full.confidence[axis][site]};
      ASSERT_LT(confidence, 1.0);
      weight += confidence / (1.0 - confidence);
      weighted += confidence / (1.0 - confidence) * double{scene.full.target[axis][site]};
    }
    EXPECT_NEAR(weight, 4.0 + 1.0 / 4.0 + 1.0 / 900.0, 1e-5);
    EXPECT_NEAR(weighted, -3.0 * 4.0 + 1.75 / 4.0 + 5.0 / 900.0, 1e-5);
  }
  EXPECT_EQ(scene.observed->given, 3U);
  EXPECT_EQ(scene.observed->acting, 3U);
  EXPECT_EQ(scene.observed->exact, 0U);
}

TEST_P(Observations, ThatFillTheImageAreMetAtEveryPixel) {
  const Extent extent = GetParam().extent;
  VectorField target(extent);
  for_each_site(extent, [&](int x, int y, int z) {
    for (std::size_t axis = 0; axis < axes(); ++axis) {
      target[axis][extent.index(x, y, z)] =
          static_cast<float>(0.1 * x - 0.2 * y + 0.3 * z + 0.02 * x * y + static_cast<double>(axis));
    }
  });
  std::string pixels;
  for (std::size_t pixel = 0; pixel < extent.sites(); ++pixel) {
    for (std::size_t axis = 0; axis < axes(); ++axis) {
      pixels += fmt::format("{} ", target[axis][pixel]);
    }
  }
  write_nrrd("target.nrrd", "float", fmt::format("{} {}", axes(), extent.text(" ")), pixels,
             fmt::format("kinds: vector domain domain{}\nspacings: nan {}\n", axes() == 3 ? " domain" : "",
                         GetParam().sides));
  write_vectors("confidence.nrrd", "1", {});
  const Scene scene = load("target = \"target.nrrd\"\nconfidence = \"confidence.nrrd\"\n");
  if (GetParam().size && GetParam().size->width < extent.width) {
    EXPECT_GT(scene.observed->farthest, 0.0) << "fewer sites than pixels cannot meet all";
    return;
  }
  EXPECT_LT(scene.observed->farthest, 0.01);
  for (std::size_t axis = 0; axis < axes(); ++axis) {
    for (const float confidence : scene.full.confidence[axis]) {
      ASSERT_EQ(confidence, 1.0F);
    }
    for_each_site(extent, [&](int x, int y, int z) {
      ASSERT_NEAR(at_pixel(scene, axis, {x, y, z}).value, double{target[axis][extent.index(x, y, z)]}, 0.01);
    });
  }
}

TEST_P(Observations, OfASideArePrescribedOnThePixelsOfTheFile) {
  const Extent extent = GetParam().extent;
  const Scene scene =
      load("[[condition]]\nwhere = \"left\"\ndx = 1.5\n[[condition]]\nwhere = \"bottom\"\ndy = 1.0\n"
           "unit = \"mm\"\n");
  if (!scene.oblong) { // else the conditions are those of the sites that were asked for
    return;
  }
  for (int y = 0; y < extent.height; ++y) {
    const AtPixel there = at_pixel(scene, 0, {0, y, 0});
    EXPECT_TRUE(there.is_certain);
    EXPECT_NEAR(there.value, 1.5, 1e-6);
  }
  for (int x = 0; x < extent.width; ++x) {
    const AtPixel there = at_pixel(scene, 1, {x, extent.height - 1, extent.depth - 1});
    EXPECT_TRUE(there.is_certain);
    EXPECT_NEAR(there.value * scene.spacing, 1.0, 1e-6);
  }
  EXPECT_FALSE(at_pixel(scene, 0, {extent.width / 2, 0, 0}).is_certain);
}

INSTANTIATE_TEST_SUITE_P(
    Of, Observations,
    testing::Values(Resampled{"1 1", {7, 6}}, Resampled{"1 2", {7, 6}}, Resampled{"0.8 1.1", {9, 8}},
                    Resampled{"1.02 1", {9, 8}}, Resampled{"1 1", {9, 8}, Extent{20, 18}},
                    Resampled{"1 1", {20, 18}, Extent{10, 9}}, Resampled{"1 2", {10, 12}, Extent{15, 36}},
                    Resampled{"1 1 2.5", {6, 5, 4}}, Resampled{"1.8 1.8 6", {7, 6, 5}},
                    Resampled{"1 1 1.02", {6, 5, 7}}, Resampled{"0.8 1.1 3", {6, 5, 4}},
                    Resampled{"0.5 0.5 5", {6, 5, 4}}, Resampled{"1 1 1", {6, 5, 4}, Extent{13, 11, 9}}));

class ObservedScene : public ImageFiles {
protected:
  void write_flat(const char* name, const char* type, const char* pixels, const char* header) const {
    write_nrrd(name, type, std::string_view(type) == "float" ? "2 3 2" : "3 2", pixels, header);
  }
  [[nodiscard]] Scene load(std::string_view first, std::string_view more = "") const {
    return load_scene(
        write("scene.toml", fmt::format("energy = \"elastic\"\n{}[[tissue]]\nlabel = 0\nmodulus = 10.0\n"
                                        "[[tissue]]\nlabel = 7\nmodulus = 30.0\n{}[image]\nlabels = "
                                        "\"labels.nrrd\"\ntarget = \"target.nrrd\"\ndeviation = "
                                        "\"deviation.nrrd\"\n",
                                        first, more))
            .string());
  }
  static constexpr const char* kinds = "kinds: vector domain domain\n";
  static constexpr const char* targets = "1 2 3 4 5 6 7 8 9 10 11 12";
  static constexpr const char* deviations = "0 0 inf inf 1 1 inf inf inf inf 2 2";
};

TEST_F(ObservedScene, TakesAStatedSpacingForAllItsImages) {
  const std::string oblong = "space dimension: 2\nspace directions: (1,0) (0,3)\nspace origin: (5,6)\n";
  write_flat("labels.nrrd", "short", "0 7 7 0 0 7", oblong.c_str());
  const std::string vectors = std::string("space dimension: 2\nspace directions: none (1,0) (0,3)\n"
                                          "space origin: (5,6)\n") +
                              kinds;
  write_flat("target.nrrd", "float", targets, vectors.c_str());
  write_flat("deviation.nrrd", "float", deviations, vectors.c_str());
  const Scene scene = load("spacing = 2.0\n");
  EXPECT_EQ(scene.extent(), (Extent{3, 2}));
  EXPECT_EQ(scene.full.target[0], (std::vector<float>{1, 3, 5, 7, 9, 11}));
  EXPECT_EQ(scene.full.confidence[1], (std::vector<float>{1.0F, 0.0F, 0.5F, 0.0F, 0.0F, 0.2F}));
  EXPECT_EQ(load("").full.sides, (std::array{1.0, 3.0, 1.0})) << "without it they are the files' own";
}

/// What is laid over another image lies at the same place, or is refused.
TEST_F(ObservedScene, RefusesImagesThatLieElsewhere) {
  const auto header = [](const char* directions, const char* origin, bool is_vector) {
    return fmt::format("space dimension: 2\nspace directions: {}{}\nspace origin: {}\n{}",
                       is_vector ? "none " : "", directions, origin, is_vector ? kinds : "");
  };
  write_flat("labels.nrrd", "short", "0 7 7 0 0 7", header("(2,0) (0,2)", "(5,6)", false).c_str());
  write_flat("deviation.nrrd", "float", deviations, header("(2,0) (0,2)", "(5,6)", true).c_str());
  for (const auto& [directions, origin, says] :
       {std::tuple{"(2,0) (0,2)", "(5,6)", ""}, std::tuple{"(2,0) (0,2)", "(5.0001,6)", ""},
        std::tuple{"(2,0) (0,2)", "(5.01,6)", "target lies elsewhere than the scene"},
        std::tuple{"(2,0) (0,2)", "(505,6)", "250 pixels away"},
        std::tuple{"(-2,0) (0,2)", "(9,6)", "mirrored"}, // from right to left
        std::tuple{"(0,2) (2,0)", "(5,6)", "turned"},
        std::tuple{"(6,0) (0,6)", "(5,6)", "target has pixels of 6 mm x 6 mm, the scene of 2 mm x 2 mm"}}) {
    SCOPED_TRACE(fmt::format("{} {}", directions, origin));
    write_flat("target.nrrd", "float", targets, header(directions, origin, true).c_str());
    if (std::string_view(says).empty()) {
      EXPECT_EQ(load("").full.target[0][1], 3.0F);
    } else {
      expect_refusal([&] { (void)load(""); }, says);
    }
  }
}

TEST_F(ObservedScene, RefusesWhatIsNoNumberWithItsPlace) {
  write_flat("labels.nrrd", "short", "0 7 7 0 0 7", "");
  write_flat("target.nrrd", "float", "1 2 3 4 nan 6 7 8 9 10 11 12", kinds);
  write_flat("deviation.nrrd", "float", deviations, kinds);
  expect_refusal([&] { (void)load(""); }, "target must be finite");
  expect_refusal([&] { (void)load(""); }, "x = 2, y = 0 is nan");
  write_flat("target.nrrd", "float", targets, kinds);
  write_flat("deviation.nrrd", "float", "0 0 inf inf nan 1 inf inf inf inf 2 2", kinds);
  expect_refusal([&] { (void)load(""); }, "x = 2, y = 0 is nan");
}

TEST_F(ObservedScene, SaysWhatHasNoEffectAndWhatIsMissing) {
  write_flat("labels.nrrd", "short", "0 7 7 0 0 7", "");
  write_flat("target.nrrd", "float", targets, kinds);
  write_flat("deviation.nrrd", "float", deviations, kinds);
  const auto condition = "[[condition]]\nwhere = \"labels\"\nlabels = [7, 9]\ndx = 1\n";
  EXPECT_THAT(load("", condition).idle, ElementsAre("[[condition]] 1 on label 9, which no pixel has"));
  EXPECT_THAT(load("", "[[tissue]]\nlabel = 8\nmodulus = 1\n").idle,
              ElementsAre("the [[tissue]] of label 8, which no pixel has"));
  write_flat("labels.nrrd", "short", "0 7 5 6 5 7", "");
  expect_refusal([&] { (void)load(""); }, "labels 5, 6 (3 pixels) have no [[tissue]]");
  EXPECT_THAT(test::refusal([&] { (void)load_scene(path("labels.nrrd").string()); }),
              HasSubstr("labels.nrrd: this is an image"));
}

} // namespace
} // namespace hdmbench
