// Every figure of `accuracy`: deviations, regions, and the thesis's scenes against
// the truths.

#include "harness/judge/tradeoff.hpp"

#include "harness/check/faults/faulty_backend.hpp"
#include "harness/scene/method.hpp"
#include "kernels/data/input_error.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

TEST(Deviation, IsTheRootOfTheMeanSquare) {
  const ReferenceField zero({2, 2});
  ReferenceField field({2, 2});
  field[0] = {3.0, 0.0, 0.0, 0.0};
  field[1] = {4.0, 0.0, 0.0, 1.0};
  EXPECT_DOUBLE_EQ(rmsd(field, zero), std::sqrt(26.0 / 4.0));
  const std::vector<std::uint8_t> last_two{0, 0, 1, 1};
  EXPECT_DOUBLE_EQ(rmsd(field, zero, last_two), std::sqrt(0.5));
  EXPECT_EQ(rmsd(field, field), 0.0);
  EXPECT_THROW((void)rmsd(field, ReferenceField({2, 3})), InputError);
}

std::vector<Judged> measure(const Scene& scene, bool quick,
                            const std::vector<std::string>& names = test::backend_names()) {
  std::vector<const Backend*> backends;
  for (const std::string& name : names) {
    backends.push_back(&test::find(name));
  }
  return measure_accuracy(scene, backends, {.repeats = 1, .quick = quick}, test::silent());
}

TEST(Accuracy, JudgesEveryMethodAndBackend) {
  for (const Scene& scene :
       {load_scene("circular", {.size = Extent{48, 40}}), load_scene("ball", {.size = Extent{14, 13, 12}})}) {
    SCOPED_TRACE(scene.name);
    const std::vector<Judged> rows = measure(scene, false);
    std::vector<std::string> methods;
    const Judged* first = nullptr;
    for (const Judged& row : rows) {
      methods.push_back(row.method);
      if (row.seconds.empty()) {
        EXPECT_EQ(row.status, JudgedStatus::skipped) << row.reason;
        continue;
      }
      EXPECT_EQ(row.status, JudgedStatus::ok) << row.method << ": " << row.reason;
      if (row.method == "icm" && row.variant.empty()) {
        first = first == nullptr ? &row : first;
        EXPECT_EQ(row.deviations.to_fem, first->deviations.to_fem) << row.backend;
        EXPECT_TRUE(row.deviations.interface_to_fem && row.deviations.elsewhere_to_fem);
      }
      if (row.method == "interpolation" || row.method == "fixed-point") {
        EXPECT_GT(row.deviations.to_fem, 0.05) << "neither is a body of this material";
      }
    }
    for (const char* method : {"fem", "fem-coarse", "fixed-point", "interpolation", "icm", "sequential"}) {
      EXPECT_THAT(methods, testing::Contains(method));
    }
    EXPECT_EQ(std::ranges::count_if(rows, [](const auto& row) { return !row.variant.empty(); }), 5);
    ASSERT_NE(first, nullptr);
  }
}

/// The third component counts, the third axis is a way to an interface.
TEST(Accuracy, OfAVolumeHasThreeAxes) {
  ReferenceField field({3, 3, 3});
  field[2][13] = 2.0;
  EXPECT_DOUBLE_EQ(rmsd(field, ReferenceField(field.extent)), std::sqrt(4.0 / 27.0));
  Scene scene = load_scene("cube", {.size = Extent{4, 4, 24}});
  std::ranges::fill(scene.full.modulus.values, 1.0F);
  std::fill_n(scene.full.modulus.values.begin(), 32, 2.0F); // two slices
  set_inverse_modulus(scene.full);
  const Truths truths = find_truths(scene, test::silent());
  for (const auto& [slice, is_near] : {std::pair{5, true}, {7, false}}) {
    const std::size_t site = scene.extent().index(1, 1, slice);
    EXPECT_EQ(truths.interface[site], is_near ? 1 : 0);
    EXPECT_EQ(truths.elsewhere[site], is_near ? 0 : 1);
  }
}

TEST(Accuracy, ALargeVolumeIsNotFactorised) {
  const Scene scene = load_scene("cube", {.size = Extent{40, 40, 40}});
  Truths none;
  none.elastic_no_poisson.emplace();
  none.fixed_point.emplace();
  for (const Rival& rival : rivals(scene, none, true)) {
    EXPECT_EQ(rival.refusal.empty(), rival.told.method != "fem") << rival.told.method;
  }
}

Scene elastic_scene(Extent size) {
  Scene scene = load_scene(size.depth > 1 ? "ball" : "circular", {.size = size});
  use_energy(scene, find_energy("elastic"));
  return scene;
}

/// Pixels from finite elements with the scene's Poisson ratio: what each method is for.
class ElasticAccuracy : public testing::TestWithParam<Extent> {};

TEST_P(ElasticAccuracy, IsDistanceFromFiniteElements) {
  const std::vector<Judged> rows =
      measure(elastic_scene(GetParam()), true, {"scalar", "openmp"}); // others: the same bits
  const std::map<std::string, std::pair<double, double>> bounds{
      {"full-multigrid", {1e-3, 0.1}}, {"conjugate-gradients", {1e-8, 1e-4}}, {"sweeps", {0.01, 30.0}}};
  std::map<std::string, Deviations> first;
  for (const Judged& row : rows) {
    if (!bounds.contains(row.method)) {
      continue;
    }
    if (row.seconds.empty()) {
      EXPECT_EQ(row.status, JudgedStatus::skipped) << row.reason;
      continue;
    }
    EXPECT_EQ(row.status, JudgedStatus::ok) << row.method << " on " << row.backend << ": " << row.reason;
    EXPECT_EQ(row.energy, "elastic");
    const auto& [low, high] = bounds.at(row.method);
    EXPECT_GT(row.deviations.to_fem, low) << row.method;
    EXPECT_LT(row.deviations.to_fem, high) << row.method;
    EXPECT_GT(row.deviations.to_fem_no_poisson, 0.1) << "another Poisson ratio is another answer";
    EXPECT_EQ(first.try_emplace(row.method, row.deviations).first->second.to_fem, row.deviations.to_fem)
        << row.backend;
  }
  EXPECT_EQ(first.size(), bounds.size());
}

INSTANTIATE_TEST_SUITE_P(Dimensions, ElasticAccuracy, testing::Values(Extent{96, 80}, Extent{18, 17, 16}),
                         [](const auto& parameter) { return "on_" + parameter.param.text("x"); });

TEST(Accuracy, OfAnElasticFieldWithOtherBitsIsNotValid) {
  const std::vector<faults::Fault> all = faults::session_faults();
  const auto fault = std::ranges::find(all, "elastic-poisson-ratio", &faults::Fault::name);
  ASSERT_NE(fault, all.end());
  const faults::FaultyBackend faulty(test::scalar(), *fault);
  const Backend* const backends[] = {&test::scalar(), &faulty};
  const std::vector<Judged> rows =
      measure_accuracy(elastic_scene({20, 20}), backends, {.repeats = 1, .quick = true}, test::silent());
  int seen = 0;
  for (const Judged& row : rows) {
    if (row.backend == fault->name) {
      ++seen;
      EXPECT_EQ(row.status, JudgedStatus::unverified) << row.method;
      EXPECT_THAT(row.reason, testing::HasSubstr("sites differ from scalar"));
    }
  }
  EXPECT_EQ(seen, 3);
}

/// The bars: RMSD in pixels of the fixed point and of ICM to finite elements without Poisson effect, at
/// 300 x 300.
struct Bar {
  const char* scene;
  double fixed_point;
  double icm;
};

class ThesisScene : public testing::TestWithParam<Bar> {};

TEST_P(ThesisScene, IsCloseToTheFiniteElements) {
  const std::vector<Judged> rows =
      measure(load_scene(GetParam().scene), true, {"scalar", "openmp"}); // others: the same bits
  for (const Judged& row : rows) {
    if (row.method == "fixed-point") {
      EXPECT_LE(row.deviations.to_fem_no_poisson, GetParam().fixed_point);
      EXPECT_GT(row.deviations.to_fem_no_poisson, 0.0);
    }
    if (row.method == "icm" && row.status == JudgedStatus::ok) {
      EXPECT_LE(row.deviations.to_fem_no_poisson, GetParam().icm) << row.backend;
    }
    if (row.method == "interpolation") {
      EXPECT_GT(row.deviations.to_fem_no_poisson, GetParam().fixed_point) << "the scene needs no model";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Simulations, ThesisScene,
                         testing::Values(Bar{"square", 0.35, 0.5}, Bar{"circular", 0.35, 0.8},
                                         Bar{"circular-radial", 0.35, 1.1}),
                         [](const auto& parameter) { return test::test_name(parameter.param.scene); });

nlohmann::json measured(double contrast) {
  return measure_continuum(contrast, std::array{33, 65, 129}, test::find("openmp"), {}, test::silent());
}

/// Stretched evenly: bilinear elements have that displacement (the patch test), and so must our field.
TEST(Continuum, OneMaterialHasNoErrorButThatOfFloat) {
  const nlohmann::json rows = measured(1.0);
  for (const nlohmann::json& row : rows) {
    EXPECT_LT(row["discretisation"]["largest"], 2e-5) << "the border is given in float32: 25 px to 24 bits";
    EXPECT_LT(row["rounding"]["largest"], 2e-5);
  }
}

TEST(Continuum, ErrorsAreApart) {
  for (const double contrast : {0.1, 10.0}) {
    const nlohmann::json rows = measured(contrast);
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_FALSE(rows.front().contains("order"));
    EXPECT_GT(rows.back()["order"], 0.8) << contrast;
    for (const nlohmann::json& row : rows) {
      const auto rmsd = [&](const char* of) { return row[of]["rmsd"].get<double>(); };
      EXPECT_GT(rmsd("discretisation"), 100.0 * rmsd("rounding")) << row["width"];
      EXPECT_LT(rmsd("algebraic"), rmsd("discretisation")) << row["width"];
      EXPECT_LT(row["rounding"]["largest"], 2e-5) << row["width"];
      EXPECT_GT(rmsd("rounding"), 0.0) << row["width"];
    }
  }
}

} // namespace
} // namespace hdmbench
