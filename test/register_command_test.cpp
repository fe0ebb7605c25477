// register and detect as a user types them: files, exit status, what they refuse.

#include "harness/judge/diagnosis/diagnosis.hpp"
#include "test/files.hpp"
#include "test/person.hpp"
#include "test/program.hpp"

namespace hdmbench {
namespace {

class RegisterCommand : public ImageFiles {
protected:
  static constexpr int side = 64;
  static constexpr Placement placement{.origin = {-70.0, 33.0, 4.0},
                                       .axes = {{{0.0, 1.0, 0.0}, {-1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}}};

  void SetUp() override {
    ImageFiles::SetUp();
    if (!IsSkipped()) {
      test::write_person(path(""), side, placement);
    }
  }

  /// Runs the program in the folder, with the scene and a row of results.
  [[nodiscard]] nlohmann::json run(int status, const std::string& words, const std::string& says) const {
    test::expect_run(status, words + " --scene person.toml --output out --json row.json", HasSubstr(says),
                     "cd " + path("").string() + ";");
    return test::read_json(path("row.json"))["results"][0];
  }
};

TEST_F(RegisterCommand, WritesAFieldPicturesAndARow) {
  for (const std::string how : {"--iterate", "--energy elastic"}) {
    SCOPED_TRACE(how);
    const nlohmann::json row =
        run(0, "register source.nrrd target.nrrd --roi region.nrrd " + how, "mutual information");
    EXPECT_EQ(row["field"], "out/displacement.nrrd");
    EXPECT_GT(row["after"]["correlation"], row["before"]["correlation"]);
    EXPECT_EQ(row["folds"], 0);
    for (const auto& picture : row["pictures"]) {
      EXPECT_TRUE(fs::exists(path(picture["file"].get<std::string>())));
    }
    const Image<VectorField> field = read_displacement(path("out/displacement.nrrd"));
    EXPECT_EQ(field.placement.origin, placement.origin);
    EXPECT_EQ(field.placement.axes, placement.axes);
    EXPECT_EQ(row["placement"]["origin"], nlohmann::json(placement.origin));
    EXPECT_NEAR(field.pixels[0][field.pixels.extent.index(32, 20)], 1.5F, 0.4F);
    EXPECT_NEAR(field.pixels[1][field.pixels.extent.index(32, 20)], -0.5F, 0.4F);
  }
}

TEST_F(RegisterCommand, DetectWritesModulusAndSignificanceAndSaysWhatItCannotTell) {
  // The target is the source moved as one: there is hardly a deformation.
  const nlohmann::json row = run(0, "detect source.nrrd target.nrrd --roi region.nrrd", "it cannot be told");
  EXPECT_GT(row["position_deviation"], 0.0);
  EXPECT_GT(row["contrast_deviation"], 0.0);
  EXPECT_EQ(row["contrast_undetermined"], true);
  EXPECT_EQ(read_scalar(path("out/modulus.nrrd")).placement.origin, placement.origin);
  const ScalarField modulus = read_scalar(path("out/modulus.nrrd")).pixels;
  const ScalarField significance = read_scalar(path("out/detection.nrrd")).pixels;
  EXPECT_EQ(modulus.values[modulus.extent.index(2, 2)], 10.0F);
  EXPECT_EQ(significance.values[significance.extent.index(2, 2)], 0.0F);
  EXPECT_NE(significance.values[significance.extent.index(34, 30)], 0.0F);
}

TEST_F(RegisterCommand, WhatCannotBeRegisteredIsSaid) {
  const Image<ScalarField> source = read_scalar(path("source.nrrd"));
  ScalarField noise(source.pixels.extent);
  ScalarField noisy = source.pixels;
  GaussianNoise random(1);
  for (std::size_t site = 0; site < noise.values.size(); ++site) {
    noise.values[site] = static_cast<float>(100.0 * random.uniform());
    noisy.values[site] += static_cast<float>(5.0 * random());
  }
  write_scalar(path("noise.nrrd"), noise, 1.0, placement);
  write_scalar(path("noisy.nrrd"), noisy, 1.0, placement);
  for (const std::string how : {"", "--iterate"}) {
    for (const auto& [target, status, kind] : {std::tuple{"source.nrrd", 0, "nothing-gained"},
                                               {"noisy.nrrd", 0, "nothing-gained"},
                                               {"noise.nrrd", 1, "no-likeness"},
                                               {"target.nrrd", 0, ""}}) {
      SCOPED_TRACE(target + how);
      const nlohmann::json row = run(status, fmt::format("register source.nrrd {} {}", target, how), kind);
      ASSERT_EQ(row.contains("warnings"), kind != std::string()) << row;
      EXPECT_TRUE(!row.contains("warnings") || row["warnings"][0]["kind"] == kind) << row;
    }
  }
}

/// Tissue does not turn over, and a displacement that makes pictures less alike is worse than none.
TEST_F(RegisterCommand, WhatNoTissueDoesIsSaid) {
  const ScalarField source = read_scalar(path("source.nrrd")).pixels;
  ScalarField shifted(source.extent);
  for_each_site(source.extent, [&](int x, int y) {
    constexpr int shift = 20;
    shifted.values[source.extent.index(x, y)] =
        x < shift ? 0.0F : source.values[source.extent.index(x - shift, y)];
  });
  write_scalar(path("shifted.nrrd"), shifted, 1.0, placement);
  const nlohmann::json row = run(1, "register source.nrrd shifted.nrrd", "worse-than-nothing");
  EXPECT_LT(row["after"]["correlation"], 0.5);
  VectorField folded({8, 8});
  folded[0][folded.extent.index(3, 4)] = 1.5F;
  ASSERT_EQ(diagnose(folded).size(), 1U);
  EXPECT_EQ(diagnose(folded)[0].kind, fold_over);
  const Similarity near{.mean_squares = 100.0, .correlation = 0.9, .mutual_information = 1.0};
  const Similarity far{.mean_squares = 101.0, .correlation = 0.8, .mutual_information = 0.9};
  const Warnings worse = diagnose(source, shifted, near, far);
  ASSERT_EQ(worse.size(), 1U);
  EXPECT_EQ(worse[0].kind, worse_than_nothing);
  EXPECT_TRUE(diagnose(source, shifted, far, near).empty());
}

TEST_F(RegisterCommand, AnInterruptedRunLeavesNothing) {
  // So many simulations take minutes.
  const test::Outcome stopped = test::hdmbench(
      "detect source.nrrd target.nrrd --roi region.nrrd --scene person.toml --output out --simulations 1000",
      "cd " + path("").string() + "; timeout --signal INT 1");
  EXPECT_EQ(stopped.status, 124) << stopped.output;
  EXPECT_TRUE(!fs::exists(path("out")) || fs::is_empty(path("out")));
}

} // namespace
} // namespace hdmbench
