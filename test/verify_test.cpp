// The checker is checked: every planted fault must turn verify red, and a sound backend must not.

#include "harness/agreement/verify.hpp"

#include "backends/registry.hpp"
#include "harness/bench.hpp"
#include "test/faulty_backend.hpp"
#include "test/random_level.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace hdmbench {
namespace {

using test::Fault;
using test::FaultyBackend;

constexpr std::array<test::Texture, 3> textures{test::Texture::smooth, test::Texture::tie_rich,
                                                test::Texture::dyadic};

Scene make_scene(Extent extent, test::Texture texture) {
  auto problem = test::random_problem(extent, texture, 21);
  Scene scene;
  scene.name = "planted";
  scene.full = std::move(problem.level);
  scene.start = std::move(problem.start);
  scene.schedule.iterations = 6;
  if (texture != test::Texture::smooth) {
    scene.schedule.start_level = 0; // interpolation between levels would leave the grid
  }
  return scene;
}

std::vector<Comparison> run(const Scene& scene, const Backend& backend) {
  const auto backends = make_backends();
  const Backend* const followers[] = {&backend};
  Progress silent(false);
  return verify(scene, *backends.front(), followers, {}, silent);
}

std::size_t middle(const VectorField& field) {
  return field.x.size() / 2;
}

std::vector<Fault> faults() {
  constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
  std::vector<Fault> list;
  list.push_back({.name = "one_site_one_ulp", .in_read = [](VectorField& field) {
                    float& value = field.x[middle(field)];
                    value = std::nextafter(value, 100.0F);
                  }});
  list.push_back(
      {.name = "last_corner_wrong", .in_read = [](VectorField& field) { field.y.back() += 0.1F; }});
  list.push_back({.name = "not_a_number_at_one_site",
                  .in_read = [=](VectorField& field) { field.y[middle(field)] = not_a_number; }});
  list.push_back({.name = "not_a_number_everywhere", .in_read = [=](VectorField& field) {
                    std::ranges::fill(field.x, not_a_number);
                    std::ranges::fill(field.y, not_a_number);
                  }});
  list.push_back(
      {.name = "components_swapped", .in_read = [](VectorField& field) { std::swap(field.x, field.y); }});
  list.push_back(
      {.name = "unwritten_output", .in_read = [](VectorField& field) { field = VectorField(field.extent); }});
  list.push_back({.name = "skipped_sweep", .in_step = [](int) { return 0; }});
  list.push_back({.name = "double_sweep", .in_step = [](int n) { return 2 * n; }});
  list.push_back({.name = "stale_upload", .one_write_behind = true});
  list.push_back({.name = "moduli_off_by_one_ulp", .in_level = [](Level& level) {
                    for (float& value : level.inverse_modulus.values) {
                      value = std::nextafter(value, 100.0F);
                    }
                  }});
  list.push_back({.name = "confidence_as_boolean", .in_level = [](Level& level) {
                    for (float& value : level.confidence.x) {
                      value = value > 0.0F ? 1.0F : 0.0F;
                    }
                  }});
  list.push_back({.name = "tie_order_reversed", .in_level = [](Level& level) {
                    std::vector<float> steps(level.steps.values().begin(), level.steps.values().end());
                    std::ranges::reverse(steps);
                    level.steps = StepSet(steps);
                  }});
  list.push_back({.name = "candidate_missing", .in_level = [](Level& level) {
                    level.steps = StepSet(level.steps.values().first(level.steps.values().size() - 1));
                  }});
  list.push_back({.name = "target_rows_shifted", .in_level = [](Level& level) {
                    const auto width = static_cast<std::size_t>(level.extent.width);
                    std::ranges::rotate(level.target.x,
                                        level.target.x.begin() +
                                            static_cast<std::ptrdiff_t>(width % level.target.x.size()));
                  }});
  list.push_back({.name = "half_float_upload", .in_write = [](VectorField& field) {
                    for (float& value : field.x) {
                      value = std::round(value * 64.0F) / 64.0F;
                    }
                  }});
  list.push_back({.name = "count_stuck_at_zero", .in_changed = [](std::int64_t) { return std::int64_t{0}; }});
  list.push_back(
      {.name = "count_off_by_one", .in_changed = [](std::int64_t changed) { return changed + 1; }});
  return list;
}

class PlantedFault : public testing::TestWithParam<Fault> {};

TEST_P(PlantedFault, TurnsVerifyRed) {
  const auto backends = make_backends();
  const FaultyBackend faulty(*backends.front(), GetParam());
  bool caught = false;
  for (const test::Texture texture : textures) {
    for (const Comparison& comparison : run(make_scene({24, 19}, texture), faulty)) {
      caught = caught || comparison.verdict == Verdict::disagree;
      if (comparison.sites_differing > 0) {
        ASSERT_TRUE(comparison.first.has_value());
        EXPECT_GE(comparison.first->iteration, 1);
      }
    }
  }
  EXPECT_TRUE(caught);
}

TEST_P(PlantedFault, InTheFieldGetsNoSpeedUp) {
  if (GetParam().in_changed || GetParam().name == "stale_upload") {
    GTEST_SKIP() << "does not touch the final field of a solution";
  }
  const auto backends = make_backends();
  const FaultyBackend faulty(*backends.front(), GetParam());
  const Backend* const both[] = {backends.front().get(), &faulty};
  Progress silent(false);
  bool caught = false;
  for (const test::Texture texture : textures) {
    const auto results = bench(make_scene({24, 19}, texture), both, {.session = {}, .repeats = 1}, silent);
    EXPECT_TRUE(results[0].valid);
    EXPECT_EQ(results[1].valid, results[1].speed_up.has_value());
    caught = caught || !results[1].valid;
  }
  EXPECT_TRUE(caught);
}

INSTANTIATE_TEST_SUITE_P(Checker, PlantedFault, testing::ValuesIn(faults()),
                         [](const auto& information) { return information.param.name; });

TEST(Verify, ASoundBackendAgrees) {
  const auto backends = make_backends();
  for (const Comparison& comparison : run(make_scene({24, 19}, test::Texture::smooth), *backends.front())) {
    EXPECT_EQ(comparison.verdict, Verdict::agree);
    EXPECT_EQ(comparison.sites_differing, 0);
    EXPECT_EQ(comparison.levels, 6);
    EXPECT_EQ(comparison.iterations, 36);
    EXPECT_EQ(comparison.sites_compared, 6 * (24 * 19 + 16 * 16 + 8 * 8 + 4 * 4 + 2 * 2 + 1));
    EXPECT_FALSE(comparison.first.has_value());
  }
}

TEST(Verify, NegativeZeroEqualsZero) {
  const auto backends = make_backends();
  const FaultyBackend negating(*backends.front(),
                               {.name = "negative_zero", .in_read = [](VectorField& field) {
                                  for (float& value : field.x) {
                                    value = value == 0.0F ? -0.0F : value;
                                  }
                                }});
  for (const Comparison& comparison : run(make_scene({24, 19}, test::Texture::tie_rich), negating)) {
    EXPECT_EQ(comparison.verdict, Verdict::agree);
  }
}

TEST(Verify, ASceneOnWhichNothingMovesIsMistrusted) {
  Scene scene = make_scene({24, 19}, test::Texture::smooth);
  scene.full.confidence = VectorField(scene.extent());
  scene.start = VectorField(scene.extent());
  const auto backends = make_backends();
  for (const Comparison& comparison : run(scene, *backends.front())) {
    EXPECT_EQ(comparison.verdict, Verdict::mistrusted);
    EXPECT_FALSE(comparison.reason.empty());
  }
}

TEST(Verify, TheFirstDifferenceIsWhereItWasPlanted) {
  const auto backends = make_backends();
  const FaultyBackend faulty(*backends.front(), {.name = "one_site", .in_read = [](VectorField& field) {
                                                   if (field.extent.width == 24) {
                                                     field.x[field.extent.index(5, 7)] += 0.5F;
                                                   }
                                                 }});
  const Scene scene = make_scene({24, 19}, test::Texture::smooth);
  for (const Comparison& comparison : run(scene, faulty)) {
    ASSERT_TRUE(comparison.first.has_value());
    EXPECT_EQ(comparison.first->level, 0);
    EXPECT_EQ(comparison.first->iteration, 1);
    EXPECT_EQ(comparison.first->x, 5);
    EXPECT_EQ(comparison.first->y, 7);
    EXPECT_FLOAT_EQ(comparison.first->found[0], comparison.first->expected[0] + 0.5F);
    EXPECT_EQ(comparison.first->found[1], comparison.first->expected[1]);
    EXPECT_NE(comparison.first->energy_found, comparison.first->energy_expected);
  }
}

TEST(Verify, AnAbsentBackendIsSkippedWithItsReason) {
  class Absent final : public Backend {
  public:
    std::string_view name() const override { return "absent"; }
    std::string_view description() const override { return ""; }
    std::vector<Device> devices() const override { throw DeviceError("the cat took it"); }

  private:
    std::unique_ptr<Session> do_open(std::size_t, const SessionOptions&) const override { return nullptr; }
  };
  for (const Comparison& comparison : run(make_scene({8, 8}, test::Texture::smooth), Absent())) {
    EXPECT_EQ(comparison.verdict, Verdict::skipped);
    EXPECT_EQ(comparison.reason, "the cat took it");
    EXPECT_EQ(comparison.sites_compared, 0);
  }
}

TEST(Verify, StopRulesStopAllBackendsAtTheSameIteration) {
  const auto backends = make_backends();
  for (const Stop stop : {Stop::still, Stop::energy}) {
    Scene scene = make_scene({24, 19}, test::Texture::smooth);
    scene.schedule.stop = stop;
    scene.schedule.epsilon = 1e-3;
    scene.schedule.iterations = 2000;
    for (const Comparison& comparison : run(scene, *backends.front())) {
      EXPECT_EQ(comparison.verdict, Verdict::agree);
      EXPECT_LT(comparison.iterations, 6 * 2000);
    }
  }
}

} // namespace
} // namespace hdmbench
