// What verify reports of sound and of spoilt backends; faults_test has the list of planted faults.

#include "harness/agreement/verify.hpp"

#include "backends/registry.hpp"
#include "harness/faults/faulty_backend.hpp"
#include "test/textured_scene.hpp"

#include <gtest/gtest.h>

namespace hdmbench {
namespace {

using faults::FaultyBackend;

Scene make_scene(Extent extent, test::Texture texture) {
  return test::textured_scene("planted", extent, texture, 21, 6);
}

TEST(Verify, ASoundBackendAgrees) {
  const auto backends = make_backends();
  for (const Comparison& comparison :
       test::verified(make_scene({24, 19}, test::Texture::smooth), *backends.front())) {
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
  for (const Comparison& comparison :
       test::verified(make_scene({24, 19}, test::Texture::tie_rich), negating)) {
    EXPECT_EQ(comparison.verdict, Verdict::agree);
  }
}

TEST(Verify, ASceneOnWhichNothingMovesIsMistrusted) {
  Scene scene = make_scene({24, 19}, test::Texture::smooth);
  scene.full.confidence = VectorField(scene.extent());
  scene.start.reset();
  const auto backends = make_backends();
  for (const Comparison& comparison : test::verified(scene, *backends.front())) {
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
  for (const Comparison& comparison : test::verified(scene, faulty)) {
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
  for (const Comparison& comparison : test::verified(make_scene({8, 8}, test::Texture::smooth), Absent())) {
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
    for (const Comparison& comparison : test::verified(scene, *backends.front())) {
      EXPECT_EQ(comparison.verdict, Verdict::agree);
      EXPECT_LT(comparison.iterations, 6 * 2000);
    }
  }
}

} // namespace
} // namespace hdmbench
