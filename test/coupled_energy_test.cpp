// A second energy, test/coupled/, through what an energy goes through: cross-check, certificates, planted
// faults, a scene file that names it; backends_test has its bits. Nothing outside test/ knows of it.

#include "test/coupled/coupled.hpp"

#include "harness/check/certificate.hpp"
#include "harness/check/faults/faulty_backend.hpp"
#include "harness/check/faults/trial.hpp"
#include "harness/scene/method.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/scenes.hpp"

#ifdef HDMBENCH_WITH_GL
#include "harness/check/faults/device_faults.hpp"
#endif

namespace hdmbench {
namespace {

using test::scalar;

/// From the null field, with a rim that pulls and an inside in which nothing happens at first.
Scene pulled_scene(Extent extent) {
  Scene scene = test::pulled_scene(extent, 3.0F);
  scene.name = "coupled";
  for_each_site(extent, [&](int x, int y) {
    const bool inside = x / (extent.width / 3) == 1 && y / (extent.height / 3) == 1;
    scene.full.modulus.values[extent.index(x, y)] = inside ? 8.0F : 1.0F;
  });
  set_inverse_modulus(scene.full);
  test::couple(scene.full);
  scene.schedule.iterations = 12;
  scene.schedule.start_level = {};
  return scene;
}

/// As users have it: a scene file or the command line names it, and `verify` compares all backends.
TEST(CoupledEnergy, IsChosenByItsName) {
  const test::TemporaryFolder folder;
  const std::string pixels = R"(size = [40, 33]
[schedule]
iterations = 6
[[tissue]]
label = 1
modulus = 20.0
[[shape]]
kind = "everything"
label = 1
[[condition]]
where = "left"
dx = -5.0
dy = 1.0
[[condition]]
where = "right"
dx = 0.0
)";
  const std::string thesis = folder.write("thesis.toml", pixels).string();
  const std::string coupled = folder.write("coupled.toml", "energy = \"coupled\"\n" + pixels).string();
  const Scene scene = load_scene(coupled);
  EXPECT_EQ(scene.full.energy, &test::coupled_energy);
  EXPECT_EQ(scene.full.inputs.size(), 1U);

  const std::string json = (folder.path() / "rows.json").string();
  (void)test::expect_run(0, fmt::format("verify '{}' --json '{}'", coupled, json));
  std::set<std::string> compared{"scalar"}; // which the others are compared with
  const nlohmann::json verified = test::read_json(json);
  for (const auto& row : verified["results"]) {
    EXPECT_NE(row["verdict"], "disagree") << row;
    if (row["verdict"] == "agree") {
      compared.insert(row["backend"].get<std::string>());
    }
  }
  for (const Backend* const backend : test::present_backends()) {
    EXPECT_TRUE(compared.contains(std::string(backend->name()))) << backend->name();
  }

  const auto mean_energy_of = [&](const std::string& arguments) {
    (void)test::expect_run(0, fmt::format("run {} --json '{}'", arguments, json));
    return test::read_json(json)["results"][0]["mean_energy"].get<double>();
  };
  const double named_by_file = mean_energy_of(fmt::format("'{}'", coupled));
  EXPECT_EQ(mean_energy_of(fmt::format("'{}' --energy coupled", thesis)), named_by_file);
  EXPECT_NE(mean_energy_of(fmt::format("'{}'", thesis)), named_by_file);
  EXPECT_EQ(mean_energy_of(fmt::format("'{}' --energy hdm", coupled)),
            mean_energy_of(fmt::format("'{}'", thesis)));
  (void)test::expect_run(0, "methods", testing::HasSubstr("--energy coupled\n"));
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
  test::Problem problem = test::random_problem({9, 9}, test::Texture::smooth, 77, {}, Rule::closed_form);
  test::couple(problem.level);
  for (int x = 1; x < 8; ++x) {
    const SiteAnswer right =
        proofs_of(problem.level).specified_answer(problem.level, problem.start, 0, x, 4, 0);
    if (problem.level.confidence[1][problem.level.extent.index(x, 4)] > 0.0F) {
      continue;
    }
    EXPECT_FALSE(proofs_of(problem.level)
                     .certify(problem.level, problem.start, 0, x, 4, 0, {right[0], right[1] + 0.01F})
                     .holds);
    // An x that is off by more than rounding is no excuse for y either.
    EXPECT_FALSE(proofs_of(problem.level)
                     .certify(problem.level, problem.start, 0, x, 4, 0, {right[0] + 0.01F, right[1]})
                     .holds);
  }
}

#ifdef HDMBENCH_WITH_GL

faults::DeviceFault in_text(std::string name, std::string find, std::string replace) {
  return {.name = std::move(name),
          .what = "in the text of the coupled energy",
          .edits = {{std::move(find), std::move(replace)}}};
}

TEST(CoupledEnergy, FaultsInItsTextAreCaught) {
  const std::vector<faults::DeviceFault> list{
      in_text("input-of-the-wrong-site", "real(0.5) * (site.first_input.centre + site.first_input.west)",
              "real(0.5) * (site.first_input.centre + site.first_input.east)"),
      in_text("coupling-lost", "real gradient_y = coupling * WAY(dx, west);", "real gradient_y = real(0);"),
      in_text("coupling-sign", "real gradient_x = coupling * WAY(dy, north);",
              "real gradient_x = real(0) - coupling * WAY(dy, north);"),
      in_text("y-does-not-see-x", "prior.curvature_xy * step_x", "prior.curvature_xy * real(0)"),
      in_text("own-component-lost", "RATIO(n) * WAY(dx, n);", "RATIO(n) * real(0);"),
  };
  for (const faults::Pipeline pipeline : {faults::Pipeline::fragment, faults::Pipeline::compute}) {
    for (const faults::DeviceFault& fault : list) {
      const faults::Planted planted = faults::plant(pipeline, fault);
      faults::TrialScene scene{.label = "coupled", .scene = pulled_scene({48, 37})};
      for (std::size_t i = 0; i < scene.scene.extent().sites(); i += 7) { // y moves, too
        scene.scene.full.target[1][i] = 0.1F * static_cast<float>(i % 50);
        scene.scene.full.confidence[1][i] = 0.5F;
      }
      const nlohmann::json row = faults::try_out(planted, scalar(), std::span(&scene, 1), test::silent());
      if (!row["ran"] && row["scenes"][0]["reason"] != "") {
        GTEST_SKIP() << row["scenes"][0]["reason"];
      }
      EXPECT_EQ(row["not_planted"], "") << fault.name;
      EXPECT_TRUE(row["caught"]) << fault.name << " on " << planted.backend;
    }
  }
}

#endif

} // namespace
} // namespace hdmbench
