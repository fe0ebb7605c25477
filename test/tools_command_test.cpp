// The tools of the thesis's appendix A as a user types them.

#include "test/files.hpp"
#include "test/program.hpp"

#include "harness/check/compare.hpp"

#include <gmock/gmock.h>

namespace hdmbench {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Tools : public ImageFiles {
protected:
  [[nodiscard]] std::string at(std::string_view name) const {
    return fmt::format("'{}'", path(name).string());
  }

  static void expect_good(const std::string& arguments, std::string_view part) {
    test::expect_run(0, arguments, HasSubstr(part));
  }
};

constexpr std::string_view nodes = "id,x,y,u,v\n1,0,0,0,0\n2,10,0,10,0\n3,10,10,10,5\n4,0,10,0,5\n";
constexpr std::string_view elements = "1,1,2,3,4\n";

TEST_F(Tools, WhatExportWritesIsTheSameProblem) {
  for (const char* name : {"circular-radial", "random"}) {
    const std::string scene = std::string(name) + " --size 33x21 --prior-weight 0.4 --iterations 9";
    expect_good("export " + scene + " --output " + at("scene"), "scene.toml");
    expect_good("run " + at("scene/scene.toml") + " --output " + at("again"), "mean energy");
    expect_good("run " + scene + " --output " + at("first"), "mean energy");
    const auto first = read_vector(path("first") / (std::string(name) + ".nrrd"));
    const auto again = read_vector(path("again") / "scene.nrrd");
    EXPECT_EQ(compare(first.pixels, again.pixels).sites, 0) << name;
    EXPECT_GT(largest_magnitude(first.pixels), 1.0) << "something must have moved";
  }
}

TEST_F(Tools, ExportCanHaveTheFiniteElements) {
  expect_good("export square --size 20 --fem --output " + at("scene"), "displacement-fem.nrrd");
  const auto field = read_vector(path("scene/displacement-fem.nrrd")).pixels;
  EXPECT_EQ(field.extent, (Extent{20, 20}));
  EXPECT_EQ(field.x[field.extent.index(0, 7)], -50.0F) << "as prescribed";
}

TEST_F(Tools, FemToImage) {
  write("n.csv", nodes);
  write("e.csv", elements);
  const std::string both = "fem-to-image " + at("n.csv") + " --elements " + at("e.csv");
  expect_good(both + " --size 21x21 --output " + at("o.nrrd"), "441 of 441 pixels are defined");
  const auto image = read_vector(path("o.nrrd"));
  EXPECT_EQ(image.spacing, 0.5);
  EXPECT_FLOAT_EQ(image.pixels.x[image.pixels.extent.index(7, 3)], 3.5F) << "millimetres";
  EXPECT_FLOAT_EQ(image.pixels.y[image.pixels.extent.index(7, 3)], 0.75F);

  expect_good(both + " --size 12 --origin -1,0 --pixel 1 --output " + at("o.nrrd") + " --mask " + at("m.png"),
              "121 of 144 pixels are defined, 23 undefined ones are 0");
  const auto mask = read_scalar(path("m.png")).pixels;
  EXPECT_EQ(std::ranges::count(mask.values, 255.0F), 121);
  EXPECT_EQ(mask.values[mask.extent.index(0, 5)], 0.0F);
  expect_good("fem-to-image " + at("n.csv") + " --size 11 --reach 2 --output " + at("o.nrrd"),
              "24 of 121 pixels are defined");
}

TEST_F(Tools, PositionsToDisplacements) {
  write("raw.txt", "Width=2\nHeight=2\n\nX Trans ---\n0 1\n0 3\n\nY Trans ---\n0 0\n1 -4\n");
  expect_good("positions-to-displacements " + at("raw.txt") + " " + at("o.nrrd") + " --spacing 0.5",
              "largest displacement 5.385 px");
  const auto image = read_vector(path("o.nrrd"));
  EXPECT_EQ(image.spacing, 0.5);
  EXPECT_EQ(image.pixels.x, (std::vector<float>{0, 0, 0, 1}));
  EXPECT_EQ(image.pixels.y, (std::vector<float>{0, 0, 0, -2.5}));
}

TEST_F(Tools, EnergyPlot) {
  expect_good("energy-plot square --size 2x1 --sites 0,0 1,0 --range -60,10 --points 71 --output " +
                  at("o.svg"),
              "at -50 and 0 px");
  EXPECT_THAT(content(path("o.svg")), AllOf(HasSubstr("<svg"), HasSubstr("</svg>")));
  expect_good("energy-plot circular --size 20 --sites 5,5 6,5 --component y --start --points 5 --output " +
                  at("s.svg"),
              "as the scene starts: U = ");
}

TEST_F(Tools, TuneAgainstAFile) {
  write("patient.toml",
        "size = [20, 20]\npenalty = 100.0\nspacing = 0.6\n[random]\nseed = 2\nmodulus = [1.0, "
        "100.0]\ndisplacement = 20.0\nobserved = 0.4\n");
  const std::string scene = at("patient.toml") + " --iterations 20";
  expect_good("run " + scene + " --prior-weight 0.9 --output " + at("truth"), "mean energy");
  for (const char* method : {"simplex", "annealing"}) {
    const auto outcome =
        test::expect_run(0, "tune " + scene + " --search " + method + " --truth " + at("truth/patient.nrrd"),
                         HasSubstr(" best"));
    const auto place = outcome.output.find("alpha = 0.");
    ASSERT_NE(place, std::string::npos) << outcome.output;
    EXPECT_NEAR(std::stod(outcome.output.substr(place + 8)), 0.9, 0.02) << outcome.output;
  }
  test::expect_run(2, "tune random --size 21 --truth " + at("truth/patient.nrrd"),
                   HasSubstr("is 20 x 20 pixels, the scene is 21 x 21"));
}

} // namespace
} // namespace hdmbench
