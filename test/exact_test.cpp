// The exact tier: the proof that nothing is rounded and what it refuses, and scenes for which it holds. What
// a compiler's freedom does to these scenes is in free_backend_test.

#include "harness/check/certificate.hpp"
#include "harness/check/compare.hpp"

#include "harness/scene/level_sequence.hpp"
#include "test/files.hpp"
#include "test/scenes.hpp"

namespace hdmbench {
namespace {

using test::Texture;

/// One sweep of a level over `from` by update.inc, as the scalar backend has it for everything but
/// Update::sequential.
VectorField swept(const Level& level, const VectorField& from, int number) {
  VectorField next(level.extent);
  for_each_site(level.extent, [&](int x, int y, int z) {
    set_site(next, level.extent.index(x, y, z),
             proofs_of(level).specified_answer(level, from, number, x, y, z));
  });
  return next;
}

/// What the first sweep that is not exact says, the coarsest level first; empty where all are. The scene
/// stops after fixed iterations.
std::string inexact(const Scene& scene) {
  LevelSequence levels(scene);
  VectorField field;
  for (const int index : levels.order()) {
    const Level& level = levels.sample(index);
    field = levels.begin(index, field);
    for (int number = 0; number < levels.iterations(index) * sweeps_per_iteration(level); ++number) {
      if (const auto found = proofs_of(level).first_inexact(level, field, number)) {
        return found->text();
      }
      field = swept(level, field, number);
    }
  }
  return "";
}

class ExactScene : public testing::TestWithParam<std::string> {};

/// Every size in its own order of sites, and a small one in all orders.
TEST_P(ExactScene, IsDeclaredAndProvenAtEverySweepOfEverySizeAndOrderOfSites) {
  for (const std::optional<Extent> size :
       {std::optional<Extent>{}, {{1, 1}}, {{2, 8}}, {{16, 16}}, {{32, 16}}}) {
    for (const Update update : test::simultaneous_and_coloured) {
      Scene scene = load_scene(GetParam(), {.size = size});
      EXPECT_TRUE(scene.exact);
      if (update == Update::simultaneous || size == Extent{32, 16}) {
        scene.full.update = update;
        EXPECT_EQ(inexact(scene), "") << scene.extent().text();
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped, ExactScene,
                         testing::Values("exact-textures", "exact-pyramid", "exact-square"),
                         [](const auto& parameter) { return parameter.param.substr(6); });

TEST(Exactness, IsAPropertyOfTheDyadicTexture) {
  constexpr std::array extents{Extent{1, 1},    Extent{1, 9},   Extent{13, 1},  Extent{2, 2},
                               Extent{5, 8},    Extent{17, 3},  Extent{24, 19}, Extent{2, 2, 2},
                               Extent{3, 5, 7}, Extent{9, 4, 3}};
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Update update = test::simultaneous_and_coloured[seed % 3];
    auto [level, field] =
        test::random_problem(extents[seed % extents.size()], Texture::dyadic, seed, {}, Rule::steps, update);
    for (int number = 0; number < 8; ++number) {
      const auto found = proofs_of(level).first_inexact(level, field, number);
      ASSERT_FALSE(found) << "seed " << seed << ": " << found->text();
      field = swept(level, field, number);
    }
  }
}

/// What the proof says of a dyadic problem that was changed.
template <typename Change>
std::string inexact_after(Change change) {
  auto problem = test::random_problem({9, 7}, Texture::dyadic, 5);
  EXPECT_FALSE(proofs_of(problem.level).first_inexact(problem.level, problem.start, 0));
  change(problem);
  set_inverse_modulus(problem.level);
  set_inverse_curvature(problem.level);
  const auto found = proofs_of(problem.level).first_inexact(problem.level, problem.start, 0);
  return found ? found->text() : "";
}

TEST(Exactness, RefusesWhatRounds) {
  using Problem = test::Problem;
  const std::vector<std::pair<std::function<void(Problem&)>, const char*>> changes{
      {[](Problem& p) { p.level.steps = StepSet::parse("0,-1,-0.1,1,0.1"); }, " * -0.1: terms of up to "},
      // a candidate that is never chosen
      {[](Problem& p) { p.level.steps = StepSet::parse("0,-1,-0.25,1,1000000.1"); },
       " * 1000000.1: terms of"},
      {[](Problem& p) { p.level.modulus.values.front() = 3.0F; }, "sweep 0: 1 / 3 is not a power of two"},
      {[](Problem& p) { p.level.target[1].back() = 0.1F; }, "x = 8, y = 6"},
      {[](Problem& p) { p.start[0].back() = 0x1p22F; }, "x = 7, y = 5"},
      {[](Problem& p) { p.level.penalty = 0x1p28F; }, "268435460 * "},
      {[](Problem& p) { p.level.modulus.values[20] = p.level.modulus.values[21] = 0x1p-120F; },
       "leaves the range"},
      {[](Problem& p) { p.start[1][30] = std::nanf(""); }, "is not finite"},
      {[](Problem& p) { p.start[0][30] = 0x1p-140F; }, "x = 2, y = 2"}};
  for (const auto& [change, says] : changes) {
    EXPECT_THAT(inexact_after(change), HasSubstr(says));
  }
}

// The thesis's K on the square: all sums have 24 bits, the difference of two of them has not.
TEST(Exactness, RefusesComparisonsWhoseDifferenceRounds) {
  Scene scene = load_scene("exact-square");
  scene.full.penalty = 1000.0F;
  EXPECT_THAT(inexact(scene), testing::ContainsRegex("sweep [0-9]+: .* < .*need 25 bits"));
}

// Every operation of the specified order is exact: displacements are large, but their differences are small.
// A sum that begins with the displacements themselves would round.
TEST(Exactness, RefusesWhatOnlyAnotherOrderRounds) {
  auto [level, field] = test::random_problem({9, 7}, Texture::dyadic, 5);
  Level same = level;
  same.modulus = ScalarField(level.extent, 1.0F);
  same.confidence = VectorField(level.extent);
  set_inverse_modulus(same);
  for (float& value : field[0]) {
    value += 0x1p19F;
  }
  const VectorField rounded = swept(same, field, 0);
  VectorField moved_back = field;
  for (float& value : moved_back[0]) {
    value -= 0x1p19F;
  }
  const VectorField small = swept(same, moved_back, 0);
  for (std::size_t i = 0; i < field[0].size(); ++i) {
    EXPECT_EQ(rounded[0][i] - 0x1p19F, small[0][i]) << "the specified order rounds, too";
  }
  EXPECT_FALSE(proofs_of(same).first_inexact(same, moved_back, 0));
  EXPECT_TRUE(proofs_of(same).first_inexact(same, field, 0));
}

TEST(ExactKey, IsTakenWhereThePyramidCanBeExact) {
  const test::TemporaryFolder folder;
  const auto load = [&](const std::string& schedule, std::optional<Extent> size = {},
                        const std::string& declared = "true") {
    return load_scene(folder
                          .write("mine.toml", "size = [32, 64]\nexact = " + declared +
                                                  "\nsteps = [0.0, -1.0, 1.0]\n[schedule]\n" + schedule +
                                                  "\n[random]\nseed = 1\nmoduli = [1.0, 2.0]\n"
                                                  "displacement = 4.0\ngrid = 1.0\nobserved = 0.5\n"
                                                  "confidences = [0.5, 1.0]\n")
                          .string(),
                      {.size = size});
  };
  const std::string centred = "start_level = 2\nalignment = \"center\"";
  EXPECT_TRUE(load("start_level = 0").exact);
  EXPECT_FALSE(load("start_level = 0", {}, "false").exact);
  EXPECT_TRUE(load("start_level = 0", Extent{8, 129}).exact);
  EXPECT_TRUE(load(centred, Extent{8, 128}).exact);
  EXPECT_FALSE(load(centred, Extent{8, 129}).exact) << "interpolation rounds";
  for (const auto& [schedule, says] :
       {std::pair{"start_level = 2", "mine.toml:2"},
        std::pair{"start_level = 2", "start_level = 0, or alignment = \"center\""},
        std::pair{"method = \"annealing\"\nstart_level = 0", "exact cannot be true: only icm"},
        std::pair{"update = \"sequential\"\nstart_level = 0", "exact cannot be true: only icm"}}) {
    EXPECT_THAT(test::refusal([&, &schedule = schedule] { (void)load(schedule); }), HasSubstr(says));
  }
}

} // namespace
} // namespace hdmbench
