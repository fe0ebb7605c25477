// The speed section: ceilings, active against dense, threads; and files of before there were any of these.

#include "test/report_samples.hpp"

namespace hdmbench {
namespace {

using namespace report_samples;

class SpeedReport : public ReportFolder {};

json limited_row(const std::string& backend, const std::string& scene, int size, double median,
                 const std::string& work = "dense", int threads = 2) {
  json row = bench_row(backend, scene, size, median, 2.0);
  row.update(json::parse(R"({"bytes_per_site_update": 36.0, "operations_per_site_update": 123, "ceiling":
    {"copy_gigabytes_per_second": 20.5, "gigaoperations_per_second": 100.0}, "binding": "memory", "percent_of_ceiling": 61.4, "gigabytes_per_second": 12.6,
    "gigaoperations_per_second": 43.2, "peak_memory_bytes": 123456789, "bytes_per_site": 52.5,
    "speed_up_over_dense": null})"));
  row["work"] = work;
  row["method"] = work == "active" ? "icm-active" : "icm";
  row["threads"] = threads;
  return row;
}

json sample() {
  return document("bench",
                  rows(limited_row("openmp", "square", 300, 0.01), limited_row("openmp", "square", 1200, 0.2),
                       limited_row("openmp", "square", 1200, 0.38, "dense", 1),
                       limited_row("openmp", "square", 300, 0.002, "active"),
                       limited_row("openmp", "square", 1200, 0.016, "active"),
                       limited_row("gl-fragment", "square", 1200, 3.0),
                       limited_row("gl-compute", "square", 1200, 2.0)));
}

TEST_F(SpeedReport, HasTheRatiosOfActiveAndDense) {
  const std::string page = render(sample());
  EXPECT_THAT(page, HasSubstr("id=\"active\""));
  EXPECT_THAT(page, HasSubstr("12.5×<small>0.0160 s for 0.200 s</small>"))
      << "0.2 / 0.016, not of one thread";
  EXPECT_THAT(page, HasSubstr(">openmp, active<"));
}

TEST_F(SpeedReport, HasTheShareOfTheCeiling) {
  const std::string page = render(sample());
  EXPECT_THAT(page, HasSubstr("id=\"ceilings\""));
  EXPECT_THAT(page, HasSubstr("61 %</td>"));
  EXPECT_THAT(page, HasSubstr("of memory, 20.5 GB/s</small>"));
  EXPECT_THAT(page, HasSubstr(">52.5</td>"));
}

TEST_F(SpeedReport, ComparesTheFragmentShaderWithTheComputeShader) {
  EXPECT_THAT(render(sample()), HasSubstr("takes 1.50 times as long"));
}

TEST_F(SpeedReport, DrawsThroughputMemoryAndThreads) {
  const std::string page = render(sample());
  EXPECT_THAT(page,
              AllOf(HasSubstr("id=\"million-site-updates-a-second-square\""),
                    HasSubstr("id=\"bytes-of-memory-a-site-square\""), HasSubstr("id=\"scaling-square\"")));
  EXPECT_THAT(page, HasSubstr("ideal"));
  EXPECT_THAT(page, Not(HasSubstr("0.380"))) << "the table shows the most threads";
}

TEST_F(SpeedReport, OtherThreadsAreAnotherTiming) {
  json one = document("bench", rows(limited_row("openmp", "square", 1200, 0.38, "dense", 1)));
  json two = document("bench", rows(limited_row("openmp", "square", 1200, 0.2, "dense", 2)),
                      context("bench-1", "2026-11-22T01:02:03Z"));
  EXPECT_THAT(render_files({write("one.json", one), write("two.json", two)}),
              HasSubstr("id=\"scaling-square\""));
}

TEST_F(SpeedReport, LeavesOutWhatOldFilesDoNotHave) {
  const std::string page = render(document("bench", rows(bench_row("openmp", "square", 300, 0.01, 2.0),
                                                         bench_row("openmp", "square", 1200, 0.2, 2.0))));
  EXPECT_THAT(page, HasSubstr("id=\"plot-square\""));
  EXPECT_THAT(page, HasSubstr("id=\"million-site-updates-a-second-square\""));
  EXPECT_THAT(page,
              AllOf(Not(HasSubstr("id=\"active\"")), Not(HasSubstr("id=\"ceilings\"")),
                    Not(HasSubstr("id=\"scaling-square\"")), Not(HasSubstr("as long as a compute shader")),
                    Not(HasSubstr("id=\"bytes-of-memory-a-site-square\""))));
}

TEST_F(SpeedReport, AWithheldTimeIsInNoRatio) {
  json document = sample();
  for (json& row : document["results"]) {
    if (row["backend"] == "gl-compute" || row["work"] == "active") {
      row.update(json::parse(R"({"valid": false, "reason": "7 sites differ"})"));
    }
  }
  const std::string page = render(document);
  EXPECT_THAT(page, AllOf(Not(HasSubstr("id=\"active\"")), Not(HasSubstr("as long as a compute shader"))));
}

// An image so large that scalar was left out: a time, but no speed-up.
TEST_F(SpeedReport, ShowsTimesOfFieldsThatNobodyCompared) {
  json document = sample();
  json& row = document["results"][1];
  row["valid"] = nullptr;
  row["reason"] = "not checked against scalar";
  row["speed_up_over_scalar"] = 77.7;
  const std::string page = render(document);
  EXPECT_THAT(page, AllOf(HasSubstr("field not compared"), HasSubstr("12.5×"), Not(HasSubstr("77.7"))));
}

TEST_F(SpeedReport, NamesWhatIsMistyped) {
  json document = sample();
  document["results"][0]["work"] = "lazy";
  EXPECT_THAT(error_of(document), AllOf(HasSubstr("work"), HasSubstr("lazy")));
  document = sample();
  document["results"][0]["percent_of_ceiling"] = "much";
  EXPECT_THAT(error_of(document), HasSubstr("percent_of_ceiling"));
}

} // namespace
} // namespace hdmbench
