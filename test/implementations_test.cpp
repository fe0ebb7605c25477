// Other drivers in processes of their own: what theirs do to us is a row of a table.

#include "harness/measure/implementations.hpp"
#include "harness/measure/subprocess.hpp"
#include "harness/scene/row_fields.hpp"
#include "test/program.hpp"
#include "test/temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hdmbench {
namespace {

using testing::HasSubstr;

Implementation with_driver(const std::string& library) {
  return {library,
          {{"VK_DRIVER_FILES", HDMBENCH_DRIVERS "/" + library + ".json"},
           {"VK_ICD_FILENAMES", HDMBENCH_DRIVERS "/" + library + ".json"}}};
}

std::vector<ImplementationRow> rows_of(const std::vector<Implementation>& implementations,
                                       std::vector<std::string> verify,
                                       std::vector<std::string> backends = {"openmp"}) {
  Progress silent(false);
  return verify_implementations(implementations,
                                {.program = HDMBENCH_PROGRAM,
                                 .verify = std::move(verify),
                                 .backends = std::move(backends),
                                 .seconds = 20.0,
                                 .resident_bytes = 1'000'000'000},
                                silent);
}

TEST(Implementations, ADriverThatDoesNotComeBackIsARow) {
  Progress silent(false);
  const std::vector<ImplementationRow> rows = verify_implementations({with_driver("driver_hangs"),
                                                                      with_driver("driver_aborts"),
                                                                      with_driver("driver_allocates"),
                                                                      {"none", {}}},
                                                                     {.program = HDMBENCH_PROGRAM,
                                                                      .verify = {"tie-rich", "--sizes", "8"},
                                                                      .backends = {"openmp"},
                                                                      .seconds = 3.0,
                                                                      .resident_bytes = 400'000'000},
                                                                     silent);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].outcome, Outcome::out_of_time);
  EXPECT_THAT(rows[0].reason, HasSubstr("ended after 3 s"));
  EXPECT_EQ(rows[1].outcome, Outcome::crashed);
  EXPECT_THAT(rows[1].reason, HasSubstr("signal 6"));
  EXPECT_EQ(rows[2].outcome, Outcome::out_of_memory);
  EXPECT_GT(rows[2].peak_bytes, 400'000'000);
  EXPECT_EQ(rows[3].outcome, Outcome::passed) << rows[3].reason;
}

TEST(Implementations, WhatAnEarlierOneHasShownIsNotRunAgain) {
  const auto rows = rows_of({{"first", {}}, {"again", {}}}, {"tie-rich", "--sizes", "8"});
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].implementation, "first");
  EXPECT_EQ(rows[0].tier, Tier::bitwise);
  EXPECT_EQ(rows[0].scenes, 1);
  EXPECT_GT(rows[0].sites_compared, 0);
}

TEST(Implementations, EveryOneThatIsNotThereIsARow) {
  const Implementation none = with_driver("no_such_file");
  const auto rows = rows_of({{"as installed", {}}, {"first", none.environment}, {"second", none.environment}},
                            {"tie-rich", "--sizes", "8"}, {"vulkan-compute"});
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[1].implementation, "first");
  EXPECT_EQ(rows[1].outcome, Outcome::absent);
  EXPECT_EQ(rows[2].outcome, Outcome::absent);
  const auto as_installed = rows_of({none, {"again", none.environment}}, {}, {"vulkan-compute"});
  EXPECT_EQ(as_installed.size(), 1U) << "what is missing as installed is said once";
}

TEST(Implementations, ARunThatFailsSaysWhereAndIsRepeatable) {
  const auto failed =
      rows_of({{"as installed", {}}}, {"square", "--size", "9", "--steps", "0"}); // nothing moves
  ASSERT_EQ(failed.size(), 1U);
  EXPECT_EQ(failed[0].outcome, Outcome::failed) << failed[0].reason;
  EXPECT_THAT(failed[0].reason, HasSubstr("9 x 9 square"));
  EXPECT_THAT(failed[0].repeat, HasSubstr("hdmbench verify --backends openmp --device 0"));

  const auto refused = rows_of({{"as installed", {}}}, {"no-such-scene"});
  ASSERT_EQ(refused.size(), 1U);
  EXPECT_EQ(refused[0].outcome, Outcome::refused);
  EXPECT_THAT(refused[0].reason, HasSubstr("no-such-scene"));
}

TEST(Implementations, NothingComparedIsNoPass) {
  const auto rows = rows_of({{"as installed", {}}}, {"tie-rich", "--sizes", "8", "--update", "sequential"});
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].outcome, Outcome::refused);
  EXPECT_THROW(require_consistent({.backend = "x", .implementation = "y", .outcome = Outcome::passed}),
               Contradiction);
}

TEST(Implementations, EveryVulkanDriverFileIsKnownAlsoUnderZink) {
  std::size_t drivers = 0;
  std::size_t zinks = 0;
  for (const Implementation& known : known_implementations()) {
    const bool zink = known.name.starts_with("zink on ");
    drivers += !zink && !known.environment.empty() && known.environment[0].first == "VK_DRIVER_FILES";
    zinks += zink;
  }
  EXPECT_EQ(drivers, zinks);
}

TEST(Subprocess, EnvironmentAndLimits) {
  const test::TemporaryFolder folder;
  const std::filesystem::path output = folder.path() / "output";
  const std::filesystem::path errors = folder.path() / "errors";
  EXPECT_TRUE(run_process({"sh", "-c", "echo $HOME $HDMBENCH_NEW"}, output, errors,
                          {.environment = {{"HOME", "here"}, {"HDMBENCH_NEW", "there"}}})
                  .good());
  EXPECT_EQ(file_text(output), "here there\n");

  const ProcessEnd slow = run_process({"sleep", "60"}, output, errors, {.seconds = 0.2});
  EXPECT_TRUE(slow.out_of_time);
  EXPECT_FALSE(slow.out_of_memory);
  EXPECT_FALSE(slow.good());
  EXPECT_LT(slow.seconds, 30.0);

  const ProcessEnd quick =
      run_process({"true"}, output, errors, {.seconds = 60.0, .resident_bytes = 1 << 30});
  EXPECT_TRUE(quick.good());
  EXPECT_FALSE(quick.out_of_time);
  EXPECT_GT(quick.peak_bytes, 0);
}

} // namespace
} // namespace hdmbench
