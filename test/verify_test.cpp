// What verify reports of sound and of spoilt backends; faults_test has the list of planted faults.

#include "harness/check/faults/faulty_backend.hpp"
#include "harness/scene/method.hpp"
#include "test/scenes.hpp"

namespace hdmbench {
namespace {

using faults::FaultyBackend;

Scene make_scene(Extent extent, test::Texture texture) {
  return test::textured_scene("planted", extent, texture, 21, 6);
}

std::vector<Mode> modes_of(const std::vector<Comparison>& comparisons) {
  std::vector<Mode> modes;
  for (const Comparison& comparison : comparisons) {
    modes.push_back(comparison.mode);
  }
  return modes;
}

/// Pulled at its borders, still in the middle, from the null field on several levels.
Scene square_from_null() {
  Scene scene = load_scene("square", {.size = Extent{70, 50}});
  scene.schedule.iterations = 6;
  return scene;
}

TEST(Verify, EveryModeThatSaysSomething) {
  const Scene square = square_from_null();
  const auto comparisons = test::verified(square, test::find("openmp"));
  EXPECT_EQ(modes_of(comparisons), (std::vector{Mode::resync, Mode::free, Mode::active, Mode::pyramid}));
  for (const Comparison& comparison : comparisons) {
    EXPECT_EQ(comparison.verdict, Verdict::agree) << name_of(comparison.mode);
    EXPECT_EQ(comparison.tier, Tier::bitwise);
    EXPECT_EQ(comparison.sites_at_rest > 0, comparison.mode == Mode::active);
  }
  EXPECT_EQ(comparisons.back().sites_compared, 3 * 70 * 50) << "dense, and active twice";
  EXPECT_EQ(comparisons.back().sweeps, comparisons.front().sweeps);

  Scene with_start = square;
  with_start.start.emplace(square.extent())[0][0] = 1.0F;
  EXPECT_EQ(modes_of(test::verified(with_start, test::scalar())),
            (std::vector{Mode::resync, Mode::free, Mode::active}));
  EXPECT_FALSE(why_left_out(Mode::pyramid, with_start).empty());
  Scene coloured = square;
  use_method(coloured, find_method("coloured"), 6);
  EXPECT_EQ(modes_of(test::verified(coloured, test::scalar())),
            (std::vector{Mode::resync, Mode::free, Mode::pyramid}));
  EXPECT_FALSE(why_left_out(Mode::active, coloured).empty());
}

/// On every device that has kernels for them, whether or not solutions would ask it.
TEST(Verify, ComparesTheForcesOfLaws) {
  for (const auto& [name, size] : {std::pair{"square", Extent{31, 27}}, {"ball", Extent{11, 13, 12}}}) {
    const RegisteredEnergy& elastic = find_energy("elastic");
    Scene scene = load_scene(name, {.size = size, .law = "neo-hookean", .energy = &elastic});
    use_energy(scene, elastic);
    FaultyBackend wrong(test::find("openmp"), {.name = "force", .in_law_forces = [](VectorField& force) {
                                                 float& most = *std::ranges::max_element(force[1]);
                                                 most = std::nextafter(most, 0.0F);
                                               }});
    for (const Backend* const backend : test::present_backends()) {
      if (backend->has_elastic() && backend != &test::scalar()) {
        for (const Comparison& comparison : test::verified(scene, *backend)) {
          EXPECT_EQ(comparison.verdict, Verdict::agree) << name << ", " << backend->name();
        }
      }
    }
    const Comparison comparison = test::verified(scene, wrong).front();
    EXPECT_EQ(comparison.verdict, Verdict::disagree) << name;
    ASSERT_TRUE(comparison.first) << name;
    EXPECT_EQ(comparison.first->step, "forces of laws");
    EXPECT_EQ(comparison.certified_ties, 0);
  }
}

/// Every step of the method, and the method alone; who does not compute it is skipped and says so.
TEST(Verify, FollowsTheElasticEnergyStepByStep) {
  Scene scene = load_scene("random", {.size = Extent{33, 20}});
  for (const Method& method : find_energy("elastic").methods) {
    use_method(scene, method, 2);
    const auto comparisons = test::verified(scene, test::find("openmp"));
    EXPECT_EQ(modes_of(comparisons), (std::vector{Mode::resync, Mode::pyramid}));
    for (const Comparison& comparison : comparisons) {
      EXPECT_EQ(comparison.verdict, Verdict::agree) << method.name << ": " << comparison.reason;
      EXPECT_EQ(comparison.tier, Tier::bitwise);
      EXPECT_GE(comparison.sites_compared, 33 * 20);
    }
  }
  EXPECT_FALSE(why_left_out(Mode::active, scene).empty());

  struct Without final : Backend {
    std::string_view name() const override { return "without"; }
    std::string_view description() const override { return "the thesis's energy only"; }
    std::vector<Device> devices() const override { return test::scalar().devices(); }
    std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& options) const override {
      return test::scalar().open(options);
    }
  } const without;
  const auto skipped = test::verified(scene, without);
  EXPECT_EQ(skipped.front().verdict, Verdict::skipped);
  EXPECT_THAT(skipped.front().reason, testing::HasSubstr("does not compute the elastic energy"));
}

/// One backend never takes the results of others with it.
TEST(Verify, ABackendThatBreaksOffIsSkippedAndTheOthersGoOn) {
  auto break_off = [left = 20]() mutable {
    if (--left == 0) {
      throw DeviceError("the plug was pulled");
    }
  };
  faults::Fault fault{.name = "breaks-off"};
  fault.in_step = [break_off](int sweeps) mutable {
    break_off();
    return sweeps;
  };
  fault.in_elastic_step = [break_off](const MethodStep& /*step*/, bool /*is_waited_for*/) mutable {
    break_off();
    return true;
  };
  const FaultyBackend failing(test::scalar(), fault);
  Scene elastic = load_scene("random", {.size = Extent{33, 20}});
  use_method(elastic, find_method("conjugate-gradients"), 2);
  Scene volume = load_scene("ball", {.size = Extent{9, 8, 10}});
  for (const Scene& scene : {square_from_null(), elastic, volume}) {
    const Backend* const followers[] = {&failing, &test::find("openmp")};
    const auto comparisons = verify(scene, test::scalar(), followers, {}, test::silent());
    int broken = 0;
    for (const Comparison& one : comparisons) {
      const bool is_other = one.backend == "openmp";
      EXPECT_EQ(one.verdict, is_other && !test::is_idle(one) ? Verdict::agree : Verdict::skipped)
          << scene.name << ' ' << name_of(one.mode) << ' ' << one.reason;
      EXPECT_EQ(one.failed, !is_other) << scene.name << ' ' << name_of(one.mode);
      EXPECT_TRUE(is_other || one.reason.ends_with("the plug was pulled")) << one.reason;
      broken += one.failed ? 1 : 0;
    }
    EXPECT_GT(broken, 1) << scene.name;
  }
}

/// Nor is it taken for one that was never there.
TEST(Verify, ABackendThatIsGoneHasBrokenOff) {
  struct Going final : Backend {
    std::string_view name() const override { return "going"; }
    std::string_view description() const override { return "is there so many times"; }
    std::vector<Device> devices() const override {
      if (times-- <= 0) {
        throw DeviceError("no driver");
      }
      return test::scalar().devices();
    }
    std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& options) const override {
      return test::scalar().open(options);
    }
    mutable int times = 1000;
  } const going;
  const auto earlier = test::verified(square_from_null(), going);
  going.times = 0;
  for (const bool was_there : {true, false}) {
    auto gone = test::verified(square_from_null(), going);
    find_lost(gone, was_there ? std::span(earlier) : std::span<const Comparison>());
    for (const Comparison& one : gone) {
      EXPECT_EQ(one.verdict, Verdict::skipped);
      EXPECT_EQ(one.failed, was_there) << name_of(one.mode);
      EXPECT_EQ(one.reason,
                was_there ? "it was opened before and cannot be opened any more: no driver" : "no driver");
    }
  }
}

TEST(Verify, TheFirstDifferenceIsWhereItWasPlanted) {
  const FaultyBackend faulty(test::scalar(), {.name = "one_site", .in_read = [](VectorField& field) {
                                                if (field.extent.width == 24) {
                                                  field[0][field.extent.index(5, 7)] += 0.5F;
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
  }
}

/// What is checked on a scene that cannot show a fault is not checked.
TEST(Verify, MistrustsASceneOnWhichNothingCanGoWrong) {
  Scene still = make_scene({24, 19}, test::Texture::smooth);
  still.full.confidence = VectorField(still.extent());
  still.start = VectorField(still.extent());
  Scene prescribed = make_scene({24, 19}, test::Texture::smooth);
  prescribed.full.confidence = VectorField(prescribed.extent(), 1.0F);
  prescribed.start = prescribed.full.target;
  prescribed.full.confidence[0][0] = 0.0F;
  prescribed.schedule.start_level = 0;
  Scene elastic = load_scene("random", {.size = Extent{33, 20}});
  use_method(elastic, find_method(elastic_conjugate_gradients), 1);
  elastic.full.target = VectorField(elastic.extent());
  for (const Scene& scene : {still, prescribed, elastic}) {
    const Comparison first = test::verified(scene, test::find("openmp")).front();
    EXPECT_EQ(first.verdict, Verdict::mistrusted);
    EXPECT_FALSE(first.reason.empty());
  }
}

} // namespace
} // namespace hdmbench
