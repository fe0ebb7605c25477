// The hash, the golden file, and that a check against it turns red: per planted fault, per part of the
// hashes.

#include "harness/check/golden_file.hpp"
#include "harness/check/state_hash.hpp"

#include "harness/check/faults/session_faults.hpp"
#include "kernels/data/input_error.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

namespace hdmbench {
namespace {

using faults::Fault;
using faults::FaultyBackend;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(StateHash, IsFnv1aOfTheLittleEndianBytes) {
  StateHash hash;
  EXPECT_EQ(hash.value(), 0xcbf29ce484222325);
  hash.add(0x626f6f66); // the bytes "foob", of which the authors of FNV publish the hash
  EXPECT_EQ(hash.value(), 0xdd120e790c2512af);
}

TEST(StateHash, OfAFieldIsItsExtentAllXAndAllY) {
  VectorField field({2, 1});
  field.x = {1.0F, -0.5F};
  field.y = {0.1F, 300.0F};
  StateHash by_hand;
  for (const unsigned word : {2U, 1U, 0x3f800000U, 0xbf000000U, 0x3dcccccdU, 0x43960000U}) {
    by_hand.add(static_cast<int>(word));
  }
  EXPECT_EQ(state_hash(field), by_hand.value());
}

TEST(StateHash, SeesEveryBitButTheSignOfZero) {
  const VectorField zero({3, 2});
  VectorField field({3, 2}, -0.0F);
  EXPECT_EQ(state_hash(field), state_hash(zero));
  field.y.back() = std::numeric_limits<float>::denorm_min();
  EXPECT_NE(state_hash(field), state_hash(zero));
  EXPECT_NE(state_hash(VectorField({2, 3})), state_hash(zero));
  VectorField swapped = field;
  std::swap(swapped.x, swapped.y);
  EXPECT_NE(state_hash(swapped), state_hash(field));
}

TEST(StateHash, WhatIsNotFiniteIsAnError) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    VectorField field({3, 2});
    field.y[4] = bad;
    EXPECT_THAT(test::refusal<NotFinite>([&] { (void)state_hash(field); }), HasSubstr("y at (1, 1) is"));
  }
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
  EXPECT_TRUE(differs([&](Level& level) { nudge(level.target.y.back()); }));
  EXPECT_TRUE(differs([&](Level& level) { nudge(level.confidence.x.back()); }));
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

TEST(GoldenFile, IsReadAsItWasWritten) {
  const std::vector<GoldenEntry>& committed = committed_golden();
  const std::string text = golden_text(committed);
  const std::vector<GoldenEntry> again = read_golden(text, "again");
  ASSERT_EQ(again.size(), committed.size());
  for (std::size_t i = 0; i < again.size(); ++i) {
    EXPECT_EQ(again[i].problem, committed[i].problem);
    EXPECT_EQ(again[i].levels, committed[i].levels);
    EXPECT_THAT(inputs_difference(committed[i].inputs, again[i].inputs), IsEmpty());
  }
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

/// A small committed case, so that a planted fault costs little.
const GoldenEntry& entry_of(const std::string& scene, const std::string& method) {
  const auto& entries = committed_golden();
  const auto found = std::ranges::find_if(entries, [&](const GoldenEntry& entry) {
    return entry.problem.scene == scene && entry.problem.method == method;
  });
  if (found == entries.end()) {
    throw InputError("golden.json has no " + scene + " by " + method);
  }
  return *found;
}

Scene scene_of(const GoldenEntry& entry) {
  for (const Case& one : golden_cases()) {
    if (one.scene == entry.problem.scene && one.size == entry.problem.size) {
      Scene scene = load_case(one);
      if (case_of(scene) == entry.problem) {
        return scene;
      }
    }
  }
  throw InputError("no golden case is " + entry.problem.name());
}

GoldenResult check(const GoldenEntry& golden, const Scene& scene, const Backend& backend,
                   const SessionOptions& options = {}) {
  std::vector<GoldenSolver> solvers;
  solvers.emplace_back(test::scalar(), SessionOptions{});
  solvers.emplace_back(backend, options);
  return check_golden(scene, solvers, &golden, test::silent());
}

TEST(Golden, AnyNumberOfThreadsAndEveryRepetition) {
  const Backend& openmp = test::find("openmp");
  const GoldenEntry& simultaneous = entry_of("random", "icm-thesis-steps");
  const GoldenEntry& coloured = entry_of("random", "coloured");
  const Scene simultaneous_scene = scene_of(simultaneous);
  const Scene coloured_scene = scene_of(coloured);
  for (int threads = 1; threads <= 8; ++threads) {
    GoldenSolver solver(openmp, {.device = "", .threads = threads});
    EXPECT_EQ(solver.solve(simultaneous_scene, test::silent()), simultaneous.levels) << threads << " threads";
    EXPECT_EQ(solver.solve(coloured_scene, test::silent()), coloured.levels) << threads << " threads";
    EXPECT_EQ(solver.solve(simultaneous_scene, test::silent()), simultaneous.levels)
        << threads << " threads, again";
  }
}

TEST(Golden, PlantedFaultsAreSeenAtTheirLevel) {
  std::vector<Fault> faults;
  faults.push_back({.name = "one_ulp_on_level_2", .in_read = [](VectorField& field) {
                      if (field.extent.width == 32) {
                        field.x.back() = std::nextafter(field.x.back(), 100.0F);
                      }
                    }});
  faults.push_back({.name = "skipped_sweep_on_level_2", .in_level = [](Level& level) {
                      if (level.extent.width == 32) {
                        level.steps = StepSet::parse("0");
                      }
                    }});
  const GoldenEntry& entry = entry_of("circular", "icm");
  for (const Fault& fault : faults) {
    const GoldenResult result = check(entry, scene_of(entry), FaultyBackend(test::scalar(), fault));
    EXPECT_EQ(result.outcomes.at(0).verdict, Verdict::agree);
    EXPECT_EQ(result.outcomes.at(1).verdict, Verdict::disagree) << fault.name;
    EXPECT_EQ(result.outcomes.at(1).first_difference, 2) << fault.name;
  }
}

TEST(Golden, AFaultInOnePieceOnlyIsSeen) {
  const GoldenEntry& entry = entry_of("circular", "icm");
  for (const Fault& fault : faults::one_piece_faults()) {
    if (fault.in_changed || fault.name == "pyramid-begins-with-its-end") { // of counts and second solutions
      continue;
    }
    const GoldenResult result = check(entry, scene_of(entry), FaultyBackend(test::scalar(), fault));
    EXPECT_EQ(result.outcomes.at(0).verdict, Verdict::agree);
    EXPECT_EQ(result.outcomes.at(1).verdict, Verdict::disagree) << fault.name;
    EXPECT_THAT(result.outcomes.at(1).reason, HasSubstr("in one piece"));
    EXPECT_THAT(doubt_about(result), HasSubstr("in one piece"));
  }
}

TEST(Golden, NotANumberIsNamedWithItsPlace) {
  const FaultyBackend faulty(test::scalar(), {.name = "not_a_number", .in_read = [](VectorField& field) {
                                                field.y[0] = std::numeric_limits<float>::quiet_NaN();
                                              }});
  const GoldenEntry& entry = entry_of("tie-rich", "icm");
  const GoldenOutcome outcome = check(entry, scene_of(entry), faulty).outcomes.at(1);
  EXPECT_EQ(outcome.verdict, Verdict::disagree);
  EXPECT_THAT(outcome.reason, HasSubstr("level 0: y at (0, 0) is nan"));
}

TEST(Golden, OtherInputsAreNotBlamedOnTheSweep) {
  const GoldenEntry& entry = entry_of("circular", "icm");
  Scene scene = scene_of(entry);
  scene.full.target.x[5] = std::nextafter(scene.full.target.x[5], 100.0F);
  const GoldenResult result = check(entry, scene, test::find("openmp"));
  EXPECT_THAT(result.inputs_reason, HasSubstr("the scene itself is another one"));
  for (const GoldenOutcome& outcome : result.outcomes) {
    EXPECT_EQ(outcome.verdict, Verdict::mistrusted) << outcome.reason;
  }
  const FaultyBackend faulty(test::scalar(), {.name = "one_ulp", .in_read = [](VectorField& field) {
                                                field.x[0] = std::nextafter(field.x[0], 100.0F);
                                              }});
  EXPECT_EQ(check(entry, scene, faulty).outcomes.at(1).verdict, Verdict::disagree);
}

TEST(Golden, EveryPartOfAnEntryCounts) {
  const Backend& openmp = test::find("openmp");
  const GoldenEntry& sound = entry_of("circular", "icm");
  const Scene scene = scene_of(sound);
  const auto verdict = [&](auto&& change) {
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

TEST(Golden, OnlyWhatAllAgreeOnBecomesGolden) {
  const GoldenEntry& entry = entry_of("tie-rich", "icm");
  GoldenEntry outdated = entry;
  outdated.levels.back().hash ^= 1;
  const Scene scene = scene_of(entry);
  EXPECT_THAT(doubt_about(check(outdated, scene, test::find("openmp"))), IsEmpty());
  const FaultyBackend faulty(test::scalar(), {.name = "one_ulp", .in_read = [](VectorField& field) {
                                                field.x[0] = std::nextafter(field.x[0], 100.0F);
                                              }});
  EXPECT_THAT(doubt_about(check(entry, scene, faulty)), HasSubstr("one_ulp and scalar disagree"));
}

TEST(GoldenCommand, WritesItsResults) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "results.json";
  test::expect_run(0, "golden tie-rich --backends openmp --threads 3 --json " + file.string());
  const nlohmann::json rows = test::read_json(file)["results"];
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1]["backend"], "openmp");
  EXPECT_EQ(rows[1]["verdict"], "agree");
  EXPECT_EQ(rows[1]["levels"].size(), 1U);
  EXPECT_EQ(rows[1]["levels"][0]["hash"],
            fmt::format("{:016x}", entry_of("tie-rich", "icm").levels.back().hash));
}

TEST(GoldenCommand, RefusesWhatIsNotGolden) {
  for (const auto& [arguments, message] : {std::pair{"golden nowhere", "of the shipped scenes only"},
                                           {"golden square --write a.json", "leave out the scenes"},
                                           {"golden --backends openmp --write a.json", "excludes"},
                                           {"golden --backends none", "no backend \"none\""},
                                           {"golden --json /no/such/folder/a.json", "/no/such/folder"},
                                           {"golden --write /no/such/folder/a.json", "/no/such/folder"}}) {
    test::expect_run(2, arguments, HasSubstr(message));
  }
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

TEST(Golden, AnAbsentBackendIsSkippedWithItsReason) {
  const GoldenEntry& entry = entry_of("tie-rich", "icm");
  const GoldenOutcome outcome =
      check(entry, scene_of(entry), test::find("openmp"), {.device = "Voodoo2", .threads = 0}).outcomes.at(1);
  EXPECT_EQ(outcome.verdict, Verdict::skipped);
  EXPECT_THAT(outcome.reason, HasSubstr("Voodoo2"));
}

} // namespace
} // namespace hdmbench
