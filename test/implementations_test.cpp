// Other drivers in processes of their own: what theirs do to us is a row of a table.

#include "backends/shared/driver_trial.hpp"
#include "backends/shared/subprocess.hpp"
#include "harness/measure/implementations.hpp"
#include "test/files.hpp"
#include "test/program.hpp"

namespace hdmbench {
namespace {

Implementation with_driver(const std::string& library) {
  return {library,
          {{"VK_DRIVER_FILES", HDMBENCH_DRIVERS "/" + library + ".json"},
           {"VK_ICD_FILENAMES", HDMBENCH_DRIVERS "/" + library + ".json"}}};
}

nlohmann::json rows_of(const std::vector<Implementation>& implementations, std::vector<std::string> verify,
                       std::vector<std::string> backends = {"openmp"}, double seconds = 120.0,
                       std::int64_t resident_bytes = 1'000'000'000) {
  Progress silent(false);
  return verify_implementations(implementations,
                                {.program = HDMBENCH_PROGRAM,
                                 .verify = std::move(verify),
                                 .backends = std::move(backends),
                                 .seconds = seconds,
                                 .resident_bytes = resident_bytes},
                                silent);
}

TEST(Implementations, ADriverThatDoesNotComeBackIsARow) {
  const nlohmann::json hangs =
      rows_of({with_driver("driver_hangs")}, {"tie-rich", "--sizes", "8"}, {"openmp"}, 3.0).at(0);
  EXPECT_EQ(hangs["outcome"], "out of time");
  EXPECT_THAT(hangs["reason"].get<std::string>(), HasSubstr("ended after 3 s"));

  const nlohmann::json rows =
      rows_of({with_driver("driver_aborts"), with_driver("driver_allocates"), {"none", {}}},
              {"tie-rich", "--sizes", "8"}, {"openmp"}, 120.0, 400'000'000);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0]["outcome"], "crashed");
  EXPECT_THAT(rows[0]["reason"].get<std::string>(), HasSubstr("signal 6"));
  EXPECT_EQ(rows[1]["outcome"], "out of memory");
  EXPECT_GT(rows[1]["peak_bytes"], 399'000'000); // the kernel counts resident pages in batches
  EXPECT_EQ(rows[2]["outcome"], "passed") << rows[2]["reason"];
}

/// Before the program: the loaders of Vulkan and OpenCL find this driver only.
std::string only_driver(const std::string& library) {
  const std::string file = HDMBENCH_DRIVERS "/" + library;
  return fmt::format("VK_DRIVER_FILES={0}.json VK_ICD_FILENAMES={0}.json OCL_ICD_VENDORS={0}.icd", file);
}

TEST(DriverTrial, ADriverThatAbortsIsNotThereAndAllElseGoesOn) {
  const auto not_there = [](const char* before) {
    return HasSubstr(fmt::format("{}: the driver was ended by signal 6 (Aborted) when it was asked for its "
                                 "devices in a process of its own; its last words were: no room on this "
                                 "device",
                                 before));
  };
  const std::string aborting = only_driver("driver_aborts");
  test::expect_run(0, "devices", testing::AllOf(not_there("vulkan-compute"), not_there("opencl")), aborting);
  test::expect_run(0, "verify tie-rich --sizes 8", not_there("opencl: skipped"), aborting);
  test::expect_run(2, "verify tie-rich --sizes 8 --backends opencl", HasSubstr("no room on this device"),
                   aborting);
}

TEST(DriverTrial, HasLimitsOfTimeAndMemory) {
  for (const auto& [library, backend, words] :
       {std::tuple{"driver_hangs", "vulkan-compute", "gave no answer within 1 s"},
        std::tuple{"driver_hangs", "opencl", "gave no answer within 1 s"},
        std::tuple{"driver_allocates", "vulkan-compute", "took more than 0.4 GB"}}) {
    for (const auto& [name, value] : with_driver(library).environment) {
      ASSERT_EQ(setenv(name.c_str(), value.c_str(), 1), 0);
    }
    ASSERT_EQ(setenv("OCL_ICD_VENDORS", (HDMBENCH_DRIVERS "/" + std::string(library) + ".icd").c_str(), 1),
              0);
    const bool hangs = std::string_view(library) == "driver_hangs";
    EXPECT_THAT(try_driver(backend, {.seconds = hangs ? 1.0 : 60.0, .resident_bytes = 400'000'000}),
                HasSubstr(words));
  }
}

TEST(Gates, WhatIsSkippedOrSoftwareIsNoPass) {
  const std::string aborting = only_driver("driver_aborts");
  const auto says = testing::AllOf(HasSubstr("--fail-on-skip: not everything was run"),
                                   HasSubstr("vulkan-compute: the driver was ended by signal 6"));
  test::expect_run(1, "verify tie-rich --sizes 8 --fail-on-skip", says, aborting);
  test::expect_run(1, "probe --fail-on-skip", says, aborting);
  test::expect_run(0, "verify tie-rich --sizes 8 --backends openmp --fail-on-skip", testing::_, aborting);
  // A processor is no hardware that was wanted, and OSMesa has no other.
  test::expect_run(2, "verify tie-rich --sizes 8 --backends openmp --require-hardware",
                   HasSubstr("no backend has a device that is hardware"));
  test::expect_run(2, "bench square --size 8 --backends gl-fragment-osmesa --require-hardware",
                   HasSubstr("gl-fragment-osmesa is needed but not there"));
}

TEST(Gates, WhatAgreedBeforeHasToAgree) {
  const test::TemporaryFolder folder;
  const std::string before = (folder.path() / "before.json").string();
  const auto verify = [](const std::string& more) { return "verify tie-rich --backends openmp " + more; };
  test::expect_run(0, verify("--sizes 8 --json ") + before);
  nlohmann::json file = test::read_json(before);
  EXPECT_THAT(file["results"][0]["driver"].get<std::string>(), HasSubstr("OpenMP"));
  test::expect_run(0, verify("--sizes 8 --baseline ") + before,
                   HasSubstr("All that agreed in the baseline agrees"));
  test::expect_run(1, verify("--sizes 9 --baseline ") + before,
                   HasSubstr("8 x 8 tie-rich, icm, openmp, resync: was bitwise, is missing"));
  file["results"][0]["tier"] = "exact";
  const std::string better = folder.write("better.json", file.dump()).string();
  test::expect_run(1, verify("--sizes 8 --baseline ") + better, HasSubstr("resync: was exact, is agree"));
  test::expect_run(2, verify("--sizes 8 --baseline ") + folder.write("no.json", "{}").string(),
                   HasSubstr("no.json"));
  // What holds for nothing is no gate that was passed.
  nlohmann::json nothing = file;
  nothing["results"] = nlohmann::json::array();
  nlohmann::json disagreed = file;
  for (nlohmann::json& row : disagreed["results"]) {
    row.update({{"tier", "none"}, {"verdict", "disagree"}});
  }
  for (const nlohmann::json& one : {nothing, disagreed}) {
    test::expect_run(2, verify("--sizes 8 --baseline ") + folder.write("none.json", one.dump()).string(),
                     HasSubstr("none.json: no comparison in it agreed"));
  }
  const std::string timed = (folder.path() / "timed.json").string();
  test::expect_run(
      0, "bench square --size 16 --backends openmp --iterations 3 --repeat 1 --no-ceilings --json " + timed);
  EXPECT_THAT(test::read_json(timed)["results"][1]["driver"].get<std::string>(), HasSubstr("OpenMP"));
}

TEST(Gates, WhatComparesNothingHasNotPassed) {
  const std::string aborting = only_driver("driver_aborts");
  for (const auto& [words, says] :
       {std::pair{"verify tie-rich --sizes 8 --backends scalar", "no backend is left to compare with scalar"},
        {"verify tie-rich --sizes 8 --backends openmp --update sequential", "nothing was compared"},
        {"verify tie-rich --sizes 8 --methods sequential", "nothing was compared"},
        {"faults square --size 16 --faults last-slice-unwritten", "no fault was tried"}}) {
    test::expect_run(2, words, HasSubstr(says), aborting);
  }
}

TEST(DriverTrial, ADriverThatChangesTheArithmeticIsNamedAndTheReferenceStays) {
  const test::TemporaryFolder folder;
  for (const auto& file : fs::directory_iterator("/etc/OpenCL/vendors")) {
    fs::copy(file, folder.path());
  }
  fs::copy(HDMBENCH_DRIVERS "/driver_flushes.icd", folder.path());
  // Displacements below the smallest normal number.
  const std::string tiny =
      folder
          .write("tiny.toml", "size = [16, 16]\n[random]\nseed = 3\nmodulus = [1.0, 9.0]\n"
                              "displacement = 1e-37\nobserved = 0.3\n[schedule]\nmethod = \"closed-form\"\n"
                              "iterations = 4\n")
          .string();
  const auto named = [](const char* backend) {
    return HasSubstr(fmt::format("a driver of {} has changed the arithmetic of the whole program (subnormal "
                                 "results are 0, subnormal operands are 0)",
                                 backend));
  };
  for (const auto& [backend, scene, environment] :
       {std::tuple{"opencl", tiny,
                   fmt::format("OCL_ICD_VENDORS={0} OPENCL_VENDOR_PATH={0}", folder.path().string())},
        {"vulkan-compute", "tie-rich --sizes 8", // Mesa's rasterizer takes subnormal numbers for 0 itself
                                                 // Other tests have set the first two.
         "env -u VK_DRIVER_FILES -u VK_ICD_FILENAMES VK_ADD_DRIVER_FILES=" HDMBENCH_DRIVERS
         "/driver_flushes.json"}}) {
    test::expect_run(0, fmt::format("verify {} --backends openmp,{}", scene, backend),
                     AllOf(named(backend), HasSubstr(" 0 disagree")), environment);
  }
}

TEST(Implementations, WhatAnEarlierOneHasShownIsNotRunAgain) {
  const auto rows = rows_of({{"first", {}}, {"again", {}}}, {"tie-rich", "--sizes", "8"});
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0]["implementation"], "first");
  EXPECT_EQ(rows[0]["tier"], "bitwise");
  EXPECT_EQ(rows[0]["scenes"], 1);
  EXPECT_GT(rows[0]["sites_compared"], 0);
}

TEST(Implementations, ARunThatFailsSaysWhereAndIsRepeatable) {
  const auto failed =
      rows_of({{"as installed", {}}}, {"square", "--size", "9", "--steps", "0"}); // nothing moves
  ASSERT_EQ(failed.size(), 1U);
  EXPECT_EQ(failed[0]["outcome"], "failed") << failed[0]["reason"];
  EXPECT_THAT(failed[0]["reason"].get<std::string>(), HasSubstr("9 x 9 square"));
  EXPECT_THAT(failed[0]["repeat"].get<std::string>(),
              HasSubstr("hdmbench verify --backends openmp --device 0"));

  const auto refused = rows_of({{"as installed", {}}}, {"no-such-scene"});
  ASSERT_EQ(refused.size(), 1U);
  EXPECT_EQ(refused[0]["outcome"], "refused");
  EXPECT_THAT(refused[0]["reason"].get<std::string>(), HasSubstr("no-such-scene"));
}

} // namespace
} // namespace hdmbench
