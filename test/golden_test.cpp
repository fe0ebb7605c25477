// The hash, the golden file, and that a check against it turns red: per planted fault, per part of the
// hashes.

#include "harness/check/golden.hpp"

#include "harness/check/faults/faulty_backend.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using faults::Fault;
using faults::FaultyBackend;

TEST(StateHash, SeesEveryBitButTheSignOfZero) {
  const VectorField zero({3, 2});
  VectorField field({3, 2}, -0.0F);
  EXPECT_EQ(state_hash(field), state_hash(zero));
  field[1].back() = std::numeric_limits<float>::denorm_min();
  EXPECT_NE(state_hash(field), state_hash(zero));
  EXPECT_NE(state_hash(VectorField({2, 3})), state_hash(zero));
  VectorField swapped = field;
  std::swap(swapped[0], swapped[1]);
  EXPECT_NE(state_hash(swapped), state_hash(field));
}

TEST(StateHash, OfALevelSeesAllThatIsLoaded) {
  const Scene scene = load_case({.scene = "random", .size = Extent{9, 7}, .method = "annealing"});
  const std::uint64_t hash = level_hash(scene.full);
  const auto differs = [&](auto&& change) {
    Level level = scene.full;
    change(level);
    return level_hash(level) != hash;
  };
  const auto nudge = [](float& value) { value = std::nextafter(value, 1e9F); };
  EXPECT_FALSE(differs([](Level&) {}));
  EXPECT_TRUE(differs([&](Level& level) { nudge(level.target[1].back()); }));
  EXPECT_TRUE(differs([&](Level& level) { nudge(level.confidence[0].back()); }));
  EXPECT_TRUE(differs([&](Level& level) { nudge(level.modulus.values.back()); }));
  EXPECT_TRUE(differs([&](Level& level) { nudge(level.inverse_modulus.values.back()); }));
  EXPECT_TRUE(differs([&](Level& level) { nudge(level.penalty); }));
  EXPECT_TRUE(differs([](Level& level) { level.steps = StepSet::parse("0,1"); }));
  EXPECT_TRUE(differs([](Level& level) { level.update = Update::sequential; }));
  EXPECT_TRUE(differs([](Level& level) { level.rule = Rule::closed_form; }));
  EXPECT_TRUE(differs([](Level& level) { set_inverse_curvature(level); }));
  EXPECT_TRUE(differs([](Level& level) { level.strengths.push_back(1.0F); }));
  EXPECT_TRUE(differs([](Level& level) { ++level.seed; }));
}

TEST(GoldenFile, ADamagedOneIsRefused) {
  const std::string text = golden_text({committed_golden().front()});
  for (const auto& [found, damage] : {std::pair{"\"schema\": 1", "\"schema\": 2"},
                                      {"\"width\"", "\"wide\""},
                                      {"\"hash\": \"", "\"hash\": \"x"},
                                      {"\"inputs\": \"", "\"inputs\": \"0"},
                                      {"]}", ""}}) {
    std::string damaged = text;
    damaged.replace(damaged.find(found), std::string_view(found).size(), damage);
    EXPECT_THROW((void)read_golden(damaged, "damaged"), InputError) << damage;
  }
}

TEST(GoldenFile, TheCommittedOneHasEveryCaseAndNoOther) {
  std::size_t found = 0;
  std::size_t absent = 0;
  for (const Case& problem : golden_cases()) {
    try {
      const Case named = case_of(load_case(problem));
      EXPECT_NE(find_golden(committed_golden(), named), nullptr)
          << named.scene << ", " << named.method << ": hdmbench golden --write harness/check/golden.json";
      ++found;
    } catch (const MissingFile&) {
      ++absent;
    }
  }
  EXPECT_EQ(found + absent, committed_golden().size());
}

/// A small committed case, so that a planted fault costs little, and its scene.
struct Golden : testing::Test {
  static std::pair<GoldenEntry, Scene> committed(const std::string& name, const std::string& method) {
    for (const Case& one : golden_cases()) {
      if (one.scene != name) {
        continue;
      }
      Scene scene = load_case(one);
      const Case problem = case_of(scene);
      if (problem.method == method) {
        return {*find_golden(committed_golden(), problem), std::move(scene)};
      }
    }
    throw InputError("there is no golden case of " + name + " by " + method);
  }
};

GoldenResult check(const GoldenEntry& golden, const Scene& scene, const Backend& backend,
                   const SessionOptions& options = {}) {
  std::vector<GoldenSolver> solvers;
  solvers.emplace_back(test::scalar(), SessionOptions{});
  solvers.emplace_back(backend, options);
  return check_golden(scene, solvers, &golden, test::silent());
}

/// One unit in the last place of one number.
const Fault one_ulp{.name = "one_ulp",
                    .in_read = [](VectorField& field) { field[0][0] = std::nextafter(field[0][0], 100.0F); }};

TEST_F(Golden, PlantedFaultsAreSeenAtTheirLevel) {
  std::vector<Fault> faults;
  faults.push_back({.name = "one_ulp_on_level_2", .in_read = [](VectorField& field) {
                      if (field.extent.width == 32) {
                        field[0].back() = std::nextafter(field[0].back(), 100.0F);
                      }
                    }});
  faults.push_back({.name = "skipped_sweep_on_level_2", .in_level = [](Level& level) {
                      if (level.extent.width == 32) {
                        level.steps = StepSet::parse("0");
                      }
                    }});
  const auto [entry, scene] = committed("circular", "icm");
  for (const Fault& fault : faults) {
    const GoldenResult result = check(entry, scene, FaultyBackend(test::scalar(), fault));
    EXPECT_EQ(result.outcomes.at(0).verdict, Verdict::agree);
    EXPECT_EQ(result.outcomes.at(1).verdict, Verdict::disagree) << fault.name;
    EXPECT_EQ(result.outcomes.at(1).first_difference, 2) << fault.name;
  }
}

TEST_F(Golden, OtherInputsAreNotBlamedOnTheSweep) {
  auto [entry, scene] = committed("circular", "icm");
  scene.full.target[0][5] = std::nextafter(scene.full.target[0][5], 100.0F);
  const GoldenResult result = check(entry, scene, test::find("openmp"));
  EXPECT_THAT(result.inputs_reason, HasSubstr("the scene itself is another one"));
  for (const GoldenOutcome& outcome : result.outcomes) {
    EXPECT_EQ(outcome.verdict, Verdict::mistrusted) << outcome.reason;
  }
  const FaultyBackend faulty(test::scalar(), one_ulp);
  EXPECT_EQ(check(entry, scene, faulty).outcomes.at(1).verdict, Verdict::disagree);
}

TEST_F(Golden, EveryPartOfAnEntryCounts) {
  const Backend& openmp = test::find("openmp");
  const auto [sound, scene] = committed("circular", "icm");
  const auto verdict = [&, &sound = sound, &scene = scene](auto&& change) {
    GoldenEntry entry = sound;
    change(entry);
    return check(entry, scene, openmp).outcomes.at(1).verdict;
  };
  EXPECT_EQ(verdict([](GoldenEntry&) {}), Verdict::agree);
  EXPECT_EQ(verdict([](GoldenEntry& entry) { entry.levels.back().hash ^= 1; }), Verdict::disagree);
  EXPECT_EQ(verdict([](GoldenEntry& entry) { entry.levels.front().hash ^= 1; }), Verdict::disagree);
  EXPECT_EQ(verdict([](GoldenEntry& entry) { ++entry.levels.at(3).iterations; }), Verdict::disagree);
  EXPECT_EQ(verdict([](GoldenEntry& entry) { entry.levels.pop_back(); }), Verdict::disagree);
  EXPECT_EQ(verdict([](GoldenEntry& entry) { entry.levels.push_back(entry.levels.back()); }),
            Verdict::disagree);
  EXPECT_EQ(verdict([](GoldenEntry& entry) { entry.inputs.scene ^= 1; }), Verdict::mistrusted);
  EXPECT_EQ(verdict([](GoldenEntry& entry) { entry.inputs.levels.at(2) ^= 1; }), Verdict::mistrusted);
}

TEST_F(Golden, OnlyWhatAllAgreeOnBecomesGolden) {
  const auto [entry, scene] = committed("tie-rich", "icm");
  GoldenEntry outdated = entry;
  outdated.levels.back().hash ^= 1;
  EXPECT_THAT(doubt_about(check(outdated, scene, test::find("openmp"))), IsEmpty());
  const FaultyBackend faulty(test::scalar(), one_ulp);
  EXPECT_THAT(doubt_about(check(entry, scene, faulty)), HasSubstr("one_ulp and scalar disagree"));
}

TEST(GoldenCommand, KeepsHashesOfScenesOfTheUser) {
  const test::TemporaryFolder folder;
  const auto scene = [&](int seed) {
    return folder
        .write("mine.toml",
               fmt::format("title = \"mine\"\nsize = [20, 16]\n[random]\nseed = {}\nmodulus = [1.0, "
                           "2.0]\ndisplacement = 1.0\nobserved = 0.3\n",
                           seed))
        .string();
  };
  const std::string golden = (folder.path() / "mine.json").string();
  test::expect_run(2, "golden " + scene(1), HasSubstr("--write FILE keeps them"));
  test::expect_run(0, fmt::format("golden {} --write {}", scene(1), golden), HasSubstr("1 cases"));
  test::expect_run(0, fmt::format("golden {} --golden {} --backends openmp", scene(1), golden),
                   HasSubstr("2 solutions are golden, 0 are not"));
  test::expect_run(1, fmt::format("golden {} --golden {} --backends openmp", scene(2), golden),
                   HasSubstr("the inputs are not golden"));
  test::expect_run(2, fmt::format("golden {0} --golden {0}", scene(1)), HasSubstr("mine.toml"));
}

} // namespace
} // namespace hdmbench
