// A second energy, test/coupled/, through everything that an energy goes through: cross-check, proofs,
// certificates, planted faults, diagnosis; backends_test has its bits. Nothing outside test/ knows of it.

#include "test/coupled/coupled.hpp"

#include "backends/registry.hpp"
#include "harness/check/energy_proofs.hpp"
#include "harness/check/faults/fused_backend.hpp"
#include "harness/check/faults/session_faults.hpp"
#include "harness/check/faults/trial.hpp"
#include "harness/judge/diagnosis/measures.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/solver.hpp"
#include "kernels/data/gather.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"
#include "test/coupled/energy.hpp"
#include "test/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#ifdef HDMBENCH_WITH_GL
#include "harness/check/faults/device_faults.hpp"
#endif

namespace hdmbench {
namespace {

using test::scalar;

test::Problem coupled_problem(Extent extent, test::Texture texture, Rule rule, Update update) {
  test::Problem problem = test::random_problem(extent, texture, 77, {}, rule, update);
  test::couple(problem.level);
  return problem;
}

class CoupledOn : public testing::TestWithParam<std::string> {
protected:
  void SetUp() override {
    try {
      (void)backend().devices();
    } catch (const DeviceError& error) {
      GTEST_SKIP() << error.what();
    }
  }
  static const Backend& backend() { return test::find(GetParam()); }
};

/// From the null field, with a rim that pulls and an inside in which nothing happens at first.
Scene pulled_scene(Extent extent) {
  Scene scene = test::pulled_scene(extent, 3.0F);
  scene.name = "coupled";
  for (int y = extent.height / 3; y < extent.height / 2; ++y) {
    for (int x = extent.width / 3; x < extent.width / 2; ++x) {
      scene.full.modulus.values[extent.index(x, y)] = 8.0F;
    }
  }
  set_inverse_modulus(scene.full);
  test::couple(scene.full);
  scene.schedule.iterations = 12;
  scene.schedule.start_level = {};
  return scene;
}

TEST_P(CoupledOn, VerifyAgreesInEveryMode) {
  for (const Extent extent : {Extent{90, 61}, Extent{33, 64}}) {
    const Scene scene = pulled_scene(extent);
    const std::vector<Comparison> comparisons = test::verified(scene, backend());
    EXPECT_EQ(comparisons.size(), 4U); // the pyramid in one piece among them
    for (const Comparison& comparison : comparisons) {
      EXPECT_TRUE(comparison.verdict == Verdict::agree || test::is_idle(comparison))
          << name_of(comparison.mode) << ": " << name_of(comparison.verdict) << " " << comparison.reason;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Energy, CoupledOn, testing::ValuesIn(test::backend_names()), test::parameter_name);

TEST(CoupledEnergy, GradientAndCurvatureAreThoseOfTheEnergy) {
  using InDouble = Coupled<double>;
  const test::Problem problem =
      coupled_problem({9, 8}, test::Texture::smooth, Rule::steps, Update::simultaneous);
  const auto energy_at = [&](InDouble::Site site, double step_x, double step_y) {
    site.dx.centre += step_x;
    site.dy.centre += step_y;
    return InDouble::prior_energy(site);
  };
  for (int y = 1; y < 7; ++y) {
    for (int x = 1; x < 8; ++x) {
      const auto site = gather<InDouble>(problem.level, problem.start, x, y);
      const InDouble::Prior prior = InDouble::prior_of(site);
      for (const auto& [a, b] : {std::pair{1.0, 0.0}, std::pair{0.0, -1.0}, std::pair{0.5, 2.0}}) {
        const double change = prior.curvature_x * a * a + 2.0 * prior.curvature_xy * a * b +
                              prior.curvature_y * b * b + 2.0 * prior.gradient_x * a +
                              2.0 * prior.gradient_y * b;
        const double before = energy_at(site, 0.0, 0.0);
        EXPECT_NEAR(energy_at(site, a, b) - before, change, 1e-11 * (1.0 + std::abs(before)));
      }
    }
  }
}

TEST(CoupledEnergy, YSeesWhereXWentAndEnergyFalls) {
  Scene scene = test::plain_scene({2, 2});
  test::couple(scene.full);
  scene.full.inputs.front().values.assign(4, 0.5F);
  test::know_column(scene, 0, 2.0F);
  scene.full.rule = Rule::closed_form;
  scene.full.strengths = {1.0F};
  set_inverse_curvature(scene.full);
  const VectorField null(scene.extent());
  const auto moved = swept_site<Coupled<float>>(scene.full, null, 0, 0, 1);
  EXPECT_EQ(moved.x, 2.0F);
  EXPECT_NE(moved.y, 0.0F); // only x's step can have moved it: everything else is at rest
  scene.full.update = Update::coloured;
  VectorField field = null;
  double before = mean_energy(scene.full, field);
  for (int i = 0; i < 6; ++i) {
    const test::Problem problem{.level = scene.full, .start = field};
    field = test::swept(problem, sweeps_per_iteration(scene.full));
    EXPECT_LE(mean_energy(scene.full, field), before + 1e-5);
    before = mean_energy(scene.full, field);
  }
}

TEST(CoupledEnergy, ColouredUpdatesTakeFourSets) {
  const test::Problem problem =
      coupled_problem({21, 22}, test::Texture::smooth, Rule::closed_form, Update::coloured);
  ASSERT_EQ(sweeps_per_iteration(problem.level), 4);
  VectorField field = problem.start;
  for (int number = 0; number < 4; ++number) { // in place, from last to first
    for (int y = 21; y >= 0; --y) {
      for (int x = 20; x >= 0; --x) {
        const auto moved = swept_site<Coupled<float>>(problem.level, field, number, x, y);
        field.x[field.extent.index(x, y)] = moved.x;
        field.y[field.extent.index(x, y)] = moved.y;
      }
    }
  }
  const VectorField expected = test::swept(problem, 4);
  EXPECT_TRUE(field.x == expected.x && field.y == expected.y);
}

TEST(CoupledEnergy, ALevelWithoutItsInputIsRefused) {
  test::Problem problem = coupled_problem({5, 5}, test::Texture::smooth, Rule::steps, Update::simultaneous);
  problem.level.inputs.clear();
  EXPECT_THROW(validate(problem.level), InputError);
  test::couple(problem.level);
  problem.level.inputs.front().values[3] = std::nanf("");
  EXPECT_THROW(validate(problem.level), InputError);
}

TEST(CoupledEnergy, ExactScenesAreProvenAndInexactOnesAreNot) {
  test::Problem problem = coupled_problem({20, 17}, test::Texture::dyadic, Rule::steps, Update::simultaneous);
  EXPECT_FALSE(first_inexact(problem.level, problem.start, 0));
  problem.level.inputs.front().values[137] = 0.1F;
  const auto found = first_inexact(problem.level, problem.start, 0);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->x == 137 % 20 || found->x == 137 % 20 + 1);
  EXPECT_EQ(found->y, 137 / 20);
}

TEST(CoupledEnergy, FusedOperationsAreCertifiedAndWrongAnswersAreNot) {
  const auto fused = faults::make_fused();
  bool certified = false;
  for (const char* const method : {"icm", "closed-form", "coloured"}) {
    Scene scene = test::textured_scene("coupled", {80, 61}, test::Texture::smooth, 5, 20);
    test::couple(scene.full);
    use_method(scene, find_method(method));
    for (const Comparison& comparison : test::verified(scene, *fused)) {
      EXPECT_TRUE(comparison.verdict == Verdict::agree || comparison.verdict == Verdict::certified ||
                  test::is_idle(comparison))
          << method << ", " << name_of(comparison.mode) << ": " << name_of(comparison.verdict);
      certified = certified || comparison.verdict == Verdict::certified;
    }
  }
  EXPECT_TRUE(certified) << "nothing was fused";
  const test::Problem problem =
      coupled_problem({9, 9}, test::Texture::smooth, Rule::closed_form, Update::simultaneous);
  for (int x = 1; x < 8; ++x) {
    const SiteAnswer right = specified_answer(problem.level, problem.start, 0, x, 4);
    if (problem.level.confidence.y[problem.level.extent.index(x, 4)] > 0.0F) {
      continue;
    }
    EXPECT_FALSE(certify(problem.level, problem.start, 0, x, 4, {right.x, right.y + 0.01F}).holds);
    // An x that is off by more than rounding is no excuse for y either.
    EXPECT_FALSE(certify(problem.level, problem.start, 0, x, 4, {right.x + 0.01F, right.y}).holds);
  }
}

TEST(CoupledEnergy, FaultsOfSessionsAreCaught) {
  std::vector<Scene> scenes{pulled_scene({48, 37})};
  for (const test::Texture texture :
       {test::Texture::dyadic, test::Texture::smooth, test::Texture::tie_rich}) {
    scenes.push_back(test::textured_scene("coupled", {24, 19}, texture, 21, 6));
    test::couple(scenes.back().full);
  }
  for (const faults::Fault& fault : faults::session_faults()) {
    if (fault.method != "icm" || fault.name == "denormals-flushed") { // nothing here is denormal
      continue;
    }
    const bool caught = std::ranges::any_of(scenes, [&](const Scene& scene) {
      const faults::FaultyBackend faulty(scalar(), fault);
      return std::ranges::any_of(test::verified(scene, faulty), [](const Comparison& comparison) {
        return comparison.verdict == Verdict::disagree;
      });
    });
    EXPECT_TRUE(caught) << fault.name;
  }
}

#ifdef HDMBENCH_WITH_GL

faults::DeviceFault in_text(std::string name, std::string find, std::string replace) {
  return {.name = std::move(name),
          .what = "in the text of the coupled energy",
          .edits = {{.find = std::move(find), .replace = std::move(replace)}}};
}

TEST(CoupledEnergy, FaultsInItsTextAreCaught) {
  const std::vector<faults::DeviceFault> list{
      in_text("input-of-the-wrong-site", "real(0.5) * (site.first_input.centre + site.first_input.west)",
              "real(0.5) * (site.first_input.centre + site.first_input.east)"),
      in_text("coupling-lost", "gradient_y = gradient_y + coupling * (site.dx.centre - site.dx.west);", ""),
      in_text("coupling-sign", "site.dy.centre - site.dy.north);\n\n",
              "site.dy.north - site.dy.centre);\n\n"),
      in_text("y-does-not-see-x", "prior.curvature_xy * step_x", "prior.curvature_xy * real(0)"),
      in_text("own-column-lost", "north * (site.dx.centre - site.dx.north)", "north * real(0)"),
  };
  for (const faults::Pipeline pipeline : faults::pipelines()) {
    for (const faults::DeviceFault& fault : list) {
      const faults::Planted planted = faults::plant(pipeline, fault);
      faults::TrialScene scene{.label = "coupled", .scene = pulled_scene({48, 37})};
      for (std::size_t i = 0; i < scene.scene.extent().sites(); i += 7) { // y moves, too
        scene.scene.full.target.y[i] = 0.1F * static_cast<float>(i % 50);
        scene.scene.full.confidence.y[i] = 0.5F;
      }
      const faults::Trial trial = faults::try_out(planted, scalar(), std::span(&scene, 1), test::silent());
      if (!trial.ran() && !trial.seen.front()->reason.empty()) {
        GTEST_SKIP() << trial.seen.front()->reason;
      }
      EXPECT_EQ(trial.not_planted, "") << fault.name;
      EXPECT_TRUE(trial.caught()) << fault.name << " on " << planted.backend;
    }
  }
}

#endif

TEST(CoupledEnergy, SweepsEndAtItsFixedPoint) {
  Scene scene = pulled_scene({33, 26});
  use_method(scene, find_method("closed-form"), 2000);
  const VectorField field = Solver(scalar(), {}).solve(scene, test::silent()).displacement;
  EXPECT_LT(measure_rest(scene, field).rms, 1e-4);
  // The coupling matters: without it the field is another one.
  Scene free = scene;
  free.full.inputs.front().values.assign(scene.extent().sites(), 0.0F);
  EXPECT_GT(measure_rest(free, field).rms, 1e-3);
}

} // namespace
} // namespace hdmbench
