// Points that have moved: what their files say, and what they do in a scene.

#include "harness/scene/method.hpp"
#include "harness/scene/points.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Points : public ImageFiles {
protected:
  /// A volume of 10 x 9 x 8 cubes of 2 mm that is held on its border; `more` stands above its tables.
  [[nodiscard]] Scene load(std::string_view more, const SceneOptions& options = {}) const {
    const Extent extent{10, 9, 8};
    write_labels(
        path("labels.nrrd"), {extent, std::vector<int>(extent.sites(), 1)}, 2.0,
        {.origin = {100.0, -50.0, 7.0}, .axes = {{{-1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}}}});
    const fs::path file =
        write("scene.toml", fmt::format("energy = \"elastic\"\n[image]\nlabels = \"labels.nrrd\"\n"
                                        "[[tissue]]\nlabel = 1\nmodulus = 3.0\n[[condition]]\n"
                                        "where = \"border\"\ndx = 0\ndy = 0\ndz = 0\n{}",
                                        more));
    return load_scene(file.string(), options);
  }
};

TEST_F(Points, OfSlicerAreReadAsTheirHeadersSay) {
  const fs::path ras =
      write("ras.fcsv", "# Markups fiducial file version = 4.11\n# CoordinateSystem = RAS\n"
                        "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
                        "1,1.5,-2,3,0,0,0,1,1,1,0,tip,,\n2,4,5,6,0,0,0,1,1,1,0,base,,\n");
  const fs::path lps = write("lps.mrk.json", R"({"markups": [{"type": "Fiducial", "coordinateSystem": "LPS",
      "controlPoints": [{"label": "tip", "position": [-1, 2, 3.5]}, {"label": "base", "position": [-4, -5, 6]}]}]})");
  const auto pairs = read_point_pairs(ras, lps);
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].name, "tip");
  EXPECT_THAT(pairs[0].before, ElementsAre(-1.5, 2.0, 3.0));
  EXPECT_THAT(pairs[0].after, ElementsAre(-1.0, 2.0, 3.5));
  EXPECT_EQ(pairs[1].before, pairs[1].after);
  EXPECT_FALSE(pairs[0].deviation);
}

TEST_F(Points, OfTextAreLinesOfNumbers) {
  const auto pairs = read_point_pairs(
      write("pairs.csv", "x,y,z,dx,dy,dz\n1,2,3,0.5,0,-1\n\n# a remark\n4, 5, 6, 0, 0, 0, 1.5\r\n"));
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_THAT(pairs[0].after, ElementsAre(1.5, 2.0, 2.0));
  EXPECT_EQ(pairs[1].deviation, 1.5);
  EXPECT_EQ(read_point_pairs(write("pairs.txt", "1 2\t3  0.5 0 -1\n"))[0].after, pairs[0].after);
}

TEST_F(Points, ThatCannotBeMeantAreRefused) {
  const auto refuse = [&](const char* name, const char* text, const char* why) {
    const fs::path file = write(name, text);
    expect_refusal([&] { (void)read_point_pairs(file); }, why);
  };
  refuse("a.txt", "1 2 3 4 5\n", "a.txt:1: has 5 numbers");
  refuse("a.txt", "1 2 3 4 5 6\n1 2 3 x 5 6\n", "a.txt:2: \"x\" is no number");
  refuse("a.txt", "1 2 3 nan 5 6\n", "\"nan\" is no number");
  refuse("a.txt", "1 2 3 4 5 6 -1\n", "below 0");
  refuse("a.txt", "# nothing\n", "has no points");
  const fs::path one = write("one.fcsv", "# CoordinateSystem = LPS\n1,1,2,3,0,0,0,1,1,1,0,a,,\n");
  const fs::path two =
      write("two.fcsv", "# CoordinateSystem = LPS\n1,1,2,3,0,0,0,1,1,1,0,b,,\n2,1,2,3,0,0,0,1,1,1,0,a,,\n");
  const fs::path turned =
      write("turned.fcsv", "# CoordinateSystem = 1\n1,1,2,3,0,0,0,1,1,1,0,a,,\n2,1,2,3,0,0,0,1,1,1,0,b,,\n");
  expect_refusal([&] { (void)read_point_pairs(one, two); }, "one.fcsv has 1 points");
  expect_refusal([&] { (void)read_point_pairs(two, turned); }, "give both files the same order");
  expect_refusal([&] { (void)read_point_pairs(one, write("a.txt", "1 2 3\n")); }, "needs no second one");
  expect_refusal([&] { (void)read_point_pairs(one, write("no.fcsv", "1,1,2,3\n")); }, "neither LPS nor RAS");
  expect_refusal([&] { (void)read_point_pairs(one, write("no.json", "{}")); }, "is no file of points");
  expect_refusal([&] { (void)read_point_pairs(one); }, "has points at one time");
  expect_refusal([&] { (void)read_point_pairs("one.vtk"); }, "has points at one time");
  expect_refusal([&] { (void)read_point_pairs("one.off", "two.off"); }, "or both on surfaces");
  expect_refusal([&] { (void)load("", {.points = {one, one, one}}); }, "these are 3");
  (void)write("far.txt", "0 0 0 1 0 0\n");
  expect_refusal([&] { (void)load("[[points]]\nfile = \"far.txt\"\n"); }, "is beside the scene");
  expect_refusal([&] { (void)load("[[points]]\nfile = \"far.txt\"\nbefore = \"far.txt\"\n"); },
                 "give one file of pairs");
  expect_refusal([&] { (void)load("[[points]]\nfile = \"far.txt\"\ndeviation = -1\n"); }, "at least 0 (mm)");
  expect_refusal([&] { (void)load("[[points]]\nfile = \"far.txt\"\nspace = \"RAS\"\n"); },
                 "say it themselves");
}

/// Rows of the scene lead to the right, columns up, slices to the back. Two certain points in cells beside
/// each other, the second at a site.
TEST_F(Points, ThatAreCertainAreMetBetweenTheSites) {
  (void)write("pairs.txt", "91.0 -43.5 14.5 0.6 -0.2 0.9\n88 -42 15 0.5 0.1 -0.3\n");
  for (const bool by_option : {false, true}) {
    const Scene scene =
        by_option ? load("", {.points = {path("pairs.txt")}}) : load("[[points]]\nfile = \"pairs.txt\"\n");
    ASSERT_EQ(scene.points.size(), 2U);
    EXPECT_THAT(scene.points[0].at, ElementsAre(4.5, 3.75, 3.25));
    EXPECT_THAT(scene.points[0].target,
                ElementsAre(testing::DoubleNear(-0.3, 1e-12), testing::DoubleNear(0.45, 1e-12),
                            testing::DoubleNear(-0.1, 1e-12)));
    EXPECT_THAT(scene.points[1].at, ElementsAre(6.0, 4.0, 4.0));
    const VectorField field = test::solved(scene).displacement;
    for (const KnownPoint& point : scene.points) {
      EXPECT_LE(residual_at(point, field), 2e-6) << point.name;
    }
    int certain = 0;
    for_each_site(scene.extent(), [&](int x, int y, int z) {
      const bool is_inside = x > 0 && y > 0 && z > 0 && x < 9 && y < 8 && z < 7;
      certain += is_inside && scene.full.confidence[0][scene.extent().index(x, y, z)] >= 1.0F ? 1 : 0;
    });
    EXPECT_EQ(certain, 9); // the corners of a cell, and a site
  }
}

/// A spring at a site of 2 mm weighs as 15.625 mm^3 over its 8; what is held stays.
TEST_F(Points, WithADeviationAreSprings) {
  (void)write("pairs.txt", "90 -42 13 1 0 0\n100 -50 7 1 0 0\n");
  const Scene scene = load("[[points]]\nfile = \"pairs.txt\"\ndeviation = 1\n");
  const std::size_t site = scene.extent().index(5, 3, 4);
  // Half a pixel is 4 times the modulus, 15.625 mm^3 over 8 nearly twice that; the next sites, 2 mm of 2.5
  // away, have a fifth of its share.
  const double share = 4.0 * 15.625 / 8.0 / std::pow(1.4, 3);
  EXPECT_NEAR(scene.full.confidence[0][site], share / (1.0 + share), 1e-6);
  EXPECT_NEAR(scene.full.confidence[2][site + 1], 0.2 * share / (1.0 + 0.2 * share), 1e-6);
  EXPECT_EQ(scene.full.confidence[2][site + 2], 0.0F);
  EXPECT_EQ(scene.full.target[0][site], -0.5F);
  EXPECT_EQ(scene.full.target[0][0], 0.0F);
  EXPECT_EQ(scene.full.confidence[0][0], 1.0F);
  const double residual = residual_at(scene.points[0], test::solved(scene).displacement);
  EXPECT_GT(residual, 0.01);
  EXPECT_LT(residual, 0.5);
}

/// A label image, moduli and points are a scene.
TEST_F(Points, AndLabelsWithTheirTissuesAreAScene) {
  (void)load("");
  const SceneOptions options{
      .tissues = write("tissues.toml", "poisson = 0.4\n[[tissue]]\nlabel = 1\nmodulus = 3.0\n"),
      .points = {write("pairs.txt", "91.0 -43.5 14.5 0.6 -0.2 0.9\n")}};
  const Scene scene = load_scene(path("labels.nrrd").string(), options);
  EXPECT_EQ(scene.energy->name, "elastic");
  EXPECT_EQ(scene.elastic.poisson, 0.4);
  EXPECT_EQ(scene.full.modulus.values.front(), 3.0F);
  EXPECT_EQ(scene.full.confidence[1].front(), 1.0F); // the border
  EXPECT_LE(residual_at(scene.points.at(0), test::solved(scene).displacement), 2e-6);
  expect_refusal(
      [&] {
        (void)load_scene(path("labels.nrrd").string(),
                         {.tissues = write("scene.toml", "[image]\nlabels = \"l\"\n")});
      },
      "scene.toml: is a scene of its own");
  expect_refusal(
      [&] {
        (void)load_scene(path("labels.nrrd").string(),
                         {.tissues = write("t.toml", "[[tissue]]\nlabel = 2\nmodulus = 1\n")});
      },
      "have no [[tissue]]");
  expect_refusal([&] { (void)load_scene(path("labels.nrrd").string()); }, "--tissues FILE");
  expect_refusal([&] { (void)load_scene("square", {.tissues = "t.toml"}); }, "square has tissues of its own");
}

} // namespace
} // namespace hdmbench
