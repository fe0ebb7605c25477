#include "test/report_samples.hpp"

#include <string>

namespace hdmbench {
namespace {

using namespace report_samples;

json compare_row(const std::string& backend, const std::string& verdict, double ratio, double reach = 0.01) {
  json row =
      json::parse(R"({"scene": "square <a>", "width": 300, "height": 300, "device": "cpu", "method": "icm",
    "threads": 2, "old_seconds": [0.1, 0.2, 0.3], "new_seconds": [0.1, 0.2, 0.4], "compared": true, "remark": "",
    "ratio_of_medians": 1.0, "coverage": 0.96, "p": 0.5, "old_spread": 0.01, "new_spread": 0.01,
    "largest_good_spread": 0.02, "old_commit": "aaa1111", "new_commit": "bbb2222", "tolerance": 0.05,
    "interleaved": true})");
  row.update({{"backend", backend}, {"verdict", verdict}, {"ratio", ratio}});
  row.update({{"ratio_low", ratio - reach}, {"ratio_high", ratio + reach}});
  row["slower_than_tolerated"] = verdict == "slower" && ratio > 1.05;
  return row;
}

class CompareReport : public RowsReport {
protected:
  CompareReport() : RowsReport("compare", compare_row("openmp", "no difference seen", 1.0)) {}
};

TEST_F(CompareReport, SaysWhatBecameSlower) {
  const std::string page =
      page_of(rows(compare_row("openmp", "slower", 1.2), compare_row("scalar", "slower", 1.03),
                   compare_row("vulkan-compute", "faster", 0.5)));
  EXPECT_THAT(page, HasSubstr("Of 3 timings: 1 faster, 2 slower.</b> 1 by more than is tolerated"));
  EXPECT_THAT(page, HasSubstr("<td class=\"disagree\"><b>slower</b>"));
  EXPECT_THAT(page, HasSubstr("slower, within the tolerance"));
  EXPECT_THAT(page, HasSubstr("<td class=\"agree\"><b>faster</b>"));
  EXPECT_THAT(page, HasSubstr("1.200<small>1.190 … 1.210 (96 %)</small>"));
  EXPECT_THAT(page, HasSubstr("<code>aaa1111</code>, new is <code>bbb2222</code>"));
  EXPECT_THAT(page, HasSubstr("Measured in turn"));
  EXPECT_THAT(page, HasSubstr("square &lt;a&gt;"));
}

TEST_F(CompareReport, DrawsEveryComparedTimingOnce) {
  json left_out = compare_row("gl-fragment", "faster", 0.9);
  left_out["compared"] = false;
  left_out["remark"] = "not measured by the <new> side";
  const std::string page = page_of(rows(compare_row("openmp", "faster", 0.9), left_out));
  EXPECT_THAT(page, HasSubstr("aria-label=\"Ratios of times, new over old, on bench-1\""));
  EXPECT_THAT(page, HasSubstr("300×300, openmp, 2 threads, icm"));
  EXPECT_THAT(page, Not(HasSubstr("300×300, gl-fragment")));
  EXPECT_THAT(page, HasSubstr("not compared<small>not measured by the &lt;new&gt; side"));
}

TEST_F(CompareReport, SaysWhatWasNoisyAndMeasuredApart) {
  json row = compare_row("openmp", "too noisy to say", 1.02, 0.3);
  row["old_spread"] = 0.2;
  row["interleaved"] = false;
  const std::string page = page_of(rows(row));
  EXPECT_THAT(page, HasSubstr("1 of them is noisier than the tolerance bears"));
  EXPECT_THAT(page, HasSubstr("Measured at different times"));
  EXPECT_THAT(page_of(rows(compare_row("openmp", "no difference seen", 1.0))), Not(HasSubstr("noisier")));
}

TEST_F(CompareReport, FilesOfBeforeTellNoCommits) {
  json row = compare_row("openmp", "no difference seen", 1.0);
  for (const char* const key : {"old_commit", "new_commit", "tolerance", "interleaved"}) {
    row.erase(key);
  }
  const std::string page = page_of(rows(row));
  EXPECT_THAT(page, HasSubstr("Of 1 timing: 1 no difference seen"));
  EXPECT_THAT(page, Not(HasSubstr("Old is commit")));
}

TEST_F(CompareReport, ContradictionsAreRefused) {
  expect_refused({{"/ratio", 1.5, "ratio"},
                  {"/slower_than_tolerated", true, "contradicts"},
                  {"/verdict", "perhaps", "verdict"},
                  {"/new_seconds", json::array(), "no seconds"},
                  {"/compared", false, "remark"}});
}

} // namespace
} // namespace hdmbench
