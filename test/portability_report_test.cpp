// Machines side by side: efficiencies, performance portability, the table for the P3 Analysis Library.

#include "harness/report/portability.hpp"
#include "test/report_samples.hpp"

#include <array>

namespace hdmbench::report_samples {
namespace {

using report::ApplicationPortability;
using report::load_results;
using report::performance_portability;
using report::PortableProblem;

/// Seconds on a device of a machine; 0: not there.
json timing(const std::string& backend, const std::string& device, double seconds,
            std::optional<double> percent = std::nullopt) {
  json row = bench_row(backend, "square", 600, seconds, 1.0);
  row["device"] = device;
  if (percent) {
    row.update({{"percent_of_ceiling", *percent}, {"binding", "arithmetic"}});
  }
  return row;
}

json software_device(const std::string& backend, const std::string& device) {
  json row = device_row(backend, true);
  row["device"] = device;
  return row;
}

class PortabilityReport : public ReportFolder {
protected:
  /// bench-1: a CPU, and a driver that computes on it. bench-2: a CPU and a card.
  std::vector<Path> two_machines(const json& more = json::array()) {
    json second = rows(timing("openmp", "Test CPU", 0.5), timing("gl-compute", "card", 0.1, 40.0));
    second.insert(second.end(), more.begin(), more.end());
    return {write("devices.json", document("devices", rows(software_device("gl-compute", "llvmpipe")))),
            write("a.json", document("bench", rows(timing("openmp", "Test CPU", 1.0, 50.0),
                                                   timing("gl-compute", "llvmpipe", 4.0, 10.0)))),
            write("b.json", document("bench", second, context("bench-2")))};
  }
  static const ApplicationPortability& find(const PortableProblem& problem, const std::string& application) {
    const auto found =
        std::ranges::find(problem.applications, application, &ApplicationPortability::application);
    EXPECT_NE(found, problem.applications.end());
    return *found;
  }
};

TEST(PerformancePortability, IsTheHarmonicMean) {
  EXPECT_DOUBLE_EQ(performance_portability(std::array{1.0, 0.5}), 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(performance_portability(std::array{0.25, 0.25, 0.25}), 0.25);
  EXPECT_EQ(performance_portability(std::array{1.0, 0.0, 1.0}), 0.0);
  EXPECT_EQ(performance_portability({}), 0.0);
}

TEST_F(PortabilityReport, APlatformIsAProcessorWhateverTheDriverCallsIt) {
  const auto problems = report::portability(load_results(two_machines()));
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_EQ(problems.front().name, "square, 600 x 600, icm");
  EXPECT_THAT(problems.front().platforms, testing::ElementsAre("bench-1", "bench-2", "card (bench-2)"));
  const auto& compute = find(problems.front(), "gl-compute");
  EXPECT_DOUBLE_EQ(*compute.times[0].application_efficiency, 0.25);
  EXPECT_FALSE(compute.times[1].seconds);
  EXPECT_DOUBLE_EQ(*compute.times[2].application_efficiency, 1.0);
  EXPECT_DOUBLE_EQ(*compute.times[2].architectural_efficiency, 0.4);
  EXPECT_EQ(compute.of_applications, 0.0) << "it is not there on the CPU of bench-2";
  EXPECT_EQ(compute.of_architecture, 0.0);
  EXPECT_EQ(find(problems.front(), "openmp").of_architecture, std::nullopt)
      << "one of the times has no ceiling";
}

TEST_F(PortabilityReport, WhatRunsEverywhereHasItsMean) {
  json compute = timing("gl-compute", "Test CPU", 1.0, 20.0);
  const auto problems = report::portability(load_results(two_machines(rows(compute))));
  const auto& found = find(problems.front(), "gl-compute");
  EXPECT_DOUBLE_EQ(found.of_applications, 3.0 / (4.0 + 2.0 + 1.0));
  EXPECT_DOUBLE_EQ(*found.of_architecture, 3.0 / (10.0 + 5.0 + 2.5));
}

TEST_F(PortabilityReport, AWrongFieldCountsAsNotThere) {
  json wrong = timing("gl-compute", "Test CPU", 0.001);
  wrong.update({{"valid", false}, {"speed_up_over_scalar", nullptr}, {"reason", "another field"}});
  const auto files = two_machines(rows(wrong));
  const auto problems = report::portability(load_results(files));
  EXPECT_EQ(find(problems.front(), "gl-compute").of_applications, 0.0);
  EXPECT_DOUBLE_EQ(*find(problems.front(), "openmp").times[1].application_efficiency, 1.0)
      << "what is wrong is nobody's measure";
  EXPECT_THAT(render_files(files), HasSubstr("<td class=\"disagree\">disagrees</td>"));
}

TEST_F(PortabilityReport, SoDoesABackendThatTheCrossCheckFoundWrong) {
  auto files = two_machines();
  json row = disagreeing(verify_row("gl-compute", "free"));
  row["device"] = "card";
  files.push_back(write("verify.json", document("verify", rows(row), context("bench-2"))));
  const auto problems = report::portability(load_results(files));
  EXPECT_EQ(find(problems.front(), "gl-compute").times[2].state, report::PlatformTime::State::wrong);
  EXPECT_EQ(find(problems.front(), "gl-compute").times[0].state, report::PlatformTime::State::ran);
}

TEST_F(PortabilityReport, ThePageHasTiersTimesAndTheMetric) {
  auto files = two_machines();
  files.push_back(write("verify.json", document("verify", agreeing_rows())));
  const std::string page = render_files(files);
  EXPECT_THAT(page, HasSubstr("Machines side by side"));
  EXPECT_THAT(page, HasSubstr("card (bench-2)"));
  EXPECT_THAT(page, HasSubstr("25.0 % of the fastest, 10.0 % of the ceiling"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number agree\">bitwise<small>2 comparisons</small></td>"));
}

TEST_F(PortabilityReport, OneMachineAloneSaysWhatToType) {
  const std::string page = render(document("bench", rows(timing("openmp", "Test CPU", 1.0))));
  EXPECT_THAT(page, HasSubstr("hdmbench report A B C"));
  EXPECT_THAT(page, Not(HasSubstr("PP, fastest")));
}

TEST_F(PortabilityReport, TheTableForTheP3Library) {
  const auto files = two_machines();
  write_p3_csv(files, folder_ / "times.csv");
  std::ifstream stream(folder_ / "times.csv");
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_THAT(text, testing::StartsWith("problem,platform,application,fom\n"));
  EXPECT_THAT(text, HasSubstr("\"square, 600 x 600, icm\",\"bench-1\",\"gl-compute\",4\n"));
  EXPECT_THAT(text, HasSubstr("\"square, 600 x 600, icm\",\"bench-2\",\"gl-compute\",\n")) << "did not run";
  EXPECT_EQ(occurrences(text, "\n"), 1U + 2U * 3U);
}

/// Beside a machine that is made up.
TEST_F(PortabilityReport, TheCommittedResultsBesideAnotherMachine) {
  const Path committed = Path(HDMBENCH_SOURCE) / "reports/amd-epyc-llvmpipe";
  json card = timing("vulkan-compute", "card", 0.001);
  card.update({{"width", 1200}, {"height", 1200}});
  const auto problems = report::portability(load_results(std::vector<Path>{
      committed,
      write("b.json", document("bench", rows(card), context("bench-2", "2030-01-01T00:00:00Z")))}));
  const auto square = std::ranges::find(problems, "square, 1200 x 1200, icm", &PortableProblem::name);
  ASSERT_NE(square, problems.end());
  ASSERT_EQ(square->platforms.size(), 2U);
  EXPECT_DOUBLE_EQ(*find(*square, "openmp").times[0].application_efficiency, 1.0);
  EXPECT_LT(*find(*square, "scalar").times[0].application_efficiency, 0.2);
  EXPECT_GT(find(*square, "vulkan-compute").of_applications, 0.0);
  EXPECT_EQ(find(*square, "openmp").of_applications, 0.0);
}

} // namespace
} // namespace hdmbench::report_samples
