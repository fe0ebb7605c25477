// register and detect as a user types them: files, exit status, what they refuse.

#include "harness/applications/picture.hpp"
#include "harness/judge/registration/planted.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/sites.hpp"
#include "test/files.hpp"
#include "test/program.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>

namespace hdmbench {
namespace {

using testing::HasSubstr;

/// A disc of tissue in a folder: labels, source, target moved by two pixels, a region.
class RegisterCommand : public testing::Test {
protected:
  static constexpr int side = 64;
  static constexpr Placement placement{.origin = {-70.0, 33.0, 4.0},
                                       .axes = {{{0.0, 1.0, 0.0}, {-1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}}};

  void SetUp() override {
    if (!have_images()) {
      GTEST_SKIP() << "built without ITK (HDMBENCH_IMAGES=OFF)";
    }
    const Extent extent{side, side};
    ScalarField source(extent);
    ScalarField target(extent);
    ScalarField region(extent);
    LabelField labels{extent, std::vector<int>(extent.sites())};
    const auto gray = [](double x, double y) {
      const double radius = std::hypot(x - 32, y - 32);
      return static_cast<float>((120.0 + 60.0 * std::sin(0.6 * x) * std::cos(0.5 * y)) /
                                (1.0 + std::exp(2.0 * (radius - 24.0))));
    };
    for_each_site(extent, [&](int x, int y) {
      const std::size_t site = extent.index(x, y);
      source.values[site] = gray(x, y);
      target.values[site] = gray(x - 1.5, y + 0.5);
      labels.values[site] = std::hypot(x - 32, y - 32) < 25 ? 1 : 0;
      region.values[site] = std::hypot(x - 34, y - 30) < 8 ? 1.0F : 0.0F;
    });
    write_scalar(file("source.nrrd"), source, 1.0, placement);
    write_scalar(file("target.nrrd"), target, 1.0);
    write_scalar(file("region.nrrd"), region, 1.0);
    write_scalar(file("empty.nrrd"), ScalarField(extent), 1.0);
    ScalarField spoilt = region;
    spoilt.values[extent.index(30, 31)] = std::nanf("");
    write_scalar(file("spoilt.nrrd"), spoilt, 1.0);
    ScalarField point(extent);
    point.values[extent.index(30, 31)] = 1.0F;
    write_scalar(file("point.nrrd"), point, 1.0);
    ScalarField corner(extent);
    ScalarField noise(extent);
    ScalarField noisy = source;
    GaussianNoise random(1);
    for_each_site(extent, [&](int x, int y) {
      corner.values[extent.index(x, y)] = x < 8 && y < 8 ? 1.0F : 0.0F;
      noise.values[extent.index(x, y)] = static_cast<float>(100.0 * random.uniform());
      noisy.values[extent.index(x, y)] += static_cast<float>(5.0 * random());
    });
    write_scalar(file("corner.nrrd"), corner, 1.0);
    write_scalar(file("noise.nrrd"), noise, 1.0);
    write_scalar(file("noisy.nrrd"), noisy, 1.0);
    write_scalar(file("everywhere.nrrd"), ScalarField(extent, 1.0F), 1.0);
    write_scalar(file("constant.nrrd"), ScalarField(extent, 9.0F), 1.0);
    write_scalar(file("coarse.nrrd"), target, 2.0);
    write_scalar(file("small.nrrd"), ScalarField({32, 32}), 1.0);
    ScalarField left(extent);
    ScalarField right(extent);
    for (int y = 20; y < 40; ++y) {
      left.values[extent.index(5, y)] = 200.0F;
      right.values[extent.index(50, y)] = 200.0F;
    }
    write_scalar(file("left.nrrd"), left, 1.0);
    write_scalar(file("right.nrrd"), right, 1.0);
    write_labels(file("labels.nrrd"), labels, 1.0);
    // A volume of two slices, as other programs write it.
    std::ofstream volume(file("volume.nrrd"), std::ios::binary);
    volume << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 64 64 2\nencoding: raw\n\n"
           << std::string(std::size_t{64} * 64 * 2, 'x');
    std::ofstream(file("scene.toml")) << R"([image]
labels = "labels.nrrd"
picture = "source.nrrd"
[[tissue]]
label = 0
name = "outside"
modulus = 10.0
[[tissue]]
label = 1
name = "tissue"
modulus = 20.0
)";
    write_scalar(file("modulus.nrrd"), ScalarField(extent, 20.0F), 1.0);
    std::ofstream(file("unlabelled.toml")) << "[image]\nmodulus = \"modulus.nrrd\"\n";
  }

  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return folder_.path() / name; }
  [[nodiscard]] std::string command(const std::string& name, const std::string& source,
                                    const std::string& target, const std::string& rest = "",
                                    const std::string& scene = "scene.toml") const {
    return name + " " + file(source).string() + " " + file(target).string() + " --scene " +
           file(scene).string() + " --output " + file("out").string() + " " + rest;
  }
  [[nodiscard]] std::string region(const std::string& name = "region.nrrd") const {
    return "--roi " + file(name).string();
  }

private:
  test::TemporaryFolder folder_;
};

TEST_F(RegisterCommand, WritesAFieldPicturesAndARow) {
  for (const std::string how : {"--iterate", "--conventional demons --energy elastic"}) {
    SCOPED_TRACE(how);
    test::expect_run(0,
                     command("register", "source.nrrd", "target.nrrd",
                             how + " " + region() + " --json " + file("row.json").string()),
                     HasSubstr("mutual information"));
    const nlohmann::json row = test::read_json(file("row.json"))["results"][0];
    EXPECT_EQ(row["field"], "out/displacement.nrrd");
    EXPECT_GT(row["after"]["correlation"], row["before"]["correlation"]);
    EXPECT_EQ(row["folds"], 0);
    for (const auto& picture : row["pictures"]) {
      EXPECT_TRUE(std::filesystem::exists(file(picture["file"].get<std::string>())));
    }
    const Image<VectorField> field = read_displacement(file("out/displacement.nrrd"));
    EXPECT_EQ(field.placement.origin, placement.origin);
    EXPECT_EQ(field.placement.axes, placement.axes);
    EXPECT_EQ(row["placement"]["origin"], nlohmann::json(placement.origin));
    EXPECT_EQ(row["placement"]["direction"][0], nlohmann::json(placement.axes[0]));
    EXPECT_NEAR(field.pixels.x[field.pixels.extent.index(32, 20)], 1.5F, 0.4F);
    EXPECT_NEAR(field.pixels.y[field.pixels.extent.index(32, 20)], -0.5F, 0.4F);
  }
}

TEST_F(RegisterCommand, DetectWritesModulusAndSignificance) {
  test::expect_run(
      0, command("detect", "source.nrrd", "target.nrrd", region() + " --json " + file("row.json").string()),
      HasSubstr("standard deviations"));
  const nlohmann::json row = test::read_json(file("row.json"))["results"][0];
  EXPECT_GT(row["position_deviation"], 0.0);
  EXPECT_GT(row["contrast_deviation"], 0.0);
  EXPECT_EQ(read_scalar(file("out/modulus.nrrd")).placement.origin, placement.origin);
  const ScalarField modulus = read_scalar(file("out/modulus.nrrd")).pixels;
  const ScalarField significance = read_scalar(file("out/detection.nrrd")).pixels;
  EXPECT_EQ(modulus.values[modulus.extent.index(2, 2)], 10.0F);
  EXPECT_EQ(significance.values[significance.extent.index(2, 2)], 0.0F);
  EXPECT_NE(significance.values[significance.extent.index(34, 30)], 0.0F);
}

TEST_F(RegisterCommand, TwoPeopleAreComparedByTheirLabels) {
  std::ofstream(file("moved.toml")) << R"([image]
labels = "labels.nrrd"
picture = "target.nrrd"
[[tissue]]
label = 0
modulus = 10.0
[[tissue]]
label = 1
modulus = 20.0
)";
  const std::string both = "rivals " + file("scene.toml").string() + " --quick --other ";
  test::expect_run(0, both + file("moved.toml").string() + " --json " + file("rows.json").string(),
                   HasSubstr("overlap of the labels"));
  const nlohmann::json rows = test::read_json(file("rows.json"))["results"];
  ASSERT_GE(rows.size(), 3U);
  // The labels are the same, the pictures are not: who registers them takes the labels apart.
  EXPECT_EQ(rows[0]["method"], "no registration");
  EXPECT_EQ(rows[0]["dice"], 1.0);
  for (const auto& row : rows) {
    EXPECT_EQ(row["overlaps"].size(), 1U);
    if (row["method"] == "Algorithm 6") {
      EXPECT_LT(row["dice"], 0.98);
      EXPECT_GT(row["dice"], 0.9);
      EXPECT_GT(row["correlation"], rows[0]["correlation"]);
    }
  }
  test::expect_run(2, both + "square", HasSubstr("at one size"));
  test::expect_run(2, both + file("missing.toml").string(), HasSubstr("missing.toml"));
  test::expect_run(2, both + file("unlabelled.toml").string(), HasSubstr("pictures with labels"));
  test::expect_run(2, "rivals " + file("scene.toml").string() + " --orientation coronal",
                   HasSubstr("has no other orientation"));
  test::expect_run(2, "rivals --orientation oblique", HasSubstr("oblique"));
}

TEST_F(RegisterCommand, WhatCannotBeRegisteredIsSaid) {
  struct Case {
    const char* target;
    const char* how;
    int status;
    std::string kind;
  };
  for (const Case& one :
       std::initializer_list<Case>{{"source.nrrd", "", 0, "nothing-gained"},
                                   {"source.nrrd", "--conventional demons", 0, "nothing-gained"},
                                   {"source.nrrd", "--iterate", 0, "nothing-gained"},
                                   {"noisy.nrrd", "", 0, "nothing-gained"},
                                   {"noisy.nrrd", "--iterate", 0, "nothing-gained"},
                                   {"noise.nrrd", "", 1, "no-likeness"},
                                   {"noise.nrrd", "--conventional demons", 1, "no-likeness"},
                                   {"noise.nrrd", "--iterate", 1, "no-likeness"},
                                   {"target.nrrd", "", 0, ""},
                                   {"target.nrrd", "--iterate", 0, ""}}) {
    SCOPED_TRACE(one.target + std::string(" ") + one.how);
    test::expect_run(one.status,
                     command("register", "source.nrrd", one.target,
                             fmt::format("{} --json {}", one.how, file("row.json").string())),
                     HasSubstr(one.kind));
    const nlohmann::json row = test::read_json(file("row.json"))["results"][0];
    ASSERT_EQ(row.contains("warnings"), !one.kind.empty()) << row;
    if (!one.kind.empty()) {
      EXPECT_EQ(row["warnings"][0]["kind"], one.kind);
    }
  }
}

TEST_F(RegisterCommand, ADetectionSaysWhatItCannotTell) {
  // The target is the source moved as one: there is hardly a deformation.
  const test::Outcome outcome = test::expect_run(
      0, command("detect", "source.nrrd", "target.nrrd", region() + " --json " + file("row.json").string()),
      testing::Not(testing::AnyOf(testing::ContainsRegex("[0-9]{8}"), HasSubstr("More than chance found"))));
  EXPECT_THAT(outcome.output, HasSubstr("it cannot be told"));
  EXPECT_EQ(test::read_json(file("row.json"))["results"][0]["contrast_undetermined"], true);
}

TEST_F(RegisterCommand, AnInterruptedRunLeavesNothing) {
  // So many simulations take minutes.
  const test::Outcome stopped =
      test::hdmbench(command("detect", "source.nrrd", "target.nrrd", region() + " --simulations 1000"),
                     "timeout --signal INT 1");
  EXPECT_EQ(stopped.status, 124) << stopped.output;
  EXPECT_TRUE(!std::filesystem::exists(file("out")) || std::filesystem::is_empty(file("out")));
}

} // namespace
} // namespace hdmbench
