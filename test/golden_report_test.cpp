#include "test/report_samples.hpp"

#include <string>

namespace hdmbench {
namespace {

using namespace report_samples;

json golden_row(const std::string& backend) {
  json row = json::parse(R"({"scene": "<square>", "width": 257, "height": 130, "method": "icm",
    "device": "llvmpipe", "inputs": "0123456789abcdef", "inputs_reason": "",
    "levels": [{"level": 1, "iterations": 20, "hash": "00000000000000aa"},
               {"level": 0, "iterations": 20, "hash": "00000000000000bb"}],
    "first_difference": null, "verdict": "agree", "reason": ""})");
  row["backend"] = backend;
  return row;
}

json differing_row(const std::string& backend) {
  json row = golden_row(backend);
  row.update({{"verdict", "disagree"}, {"first_difference", 1}, {"reason", "level 1: 1 & not 2"}});
  return row;
}

json skipped_row(const std::string& backend) {
  json row = golden_row(backend);
  row.update({{"verdict", "skipped"}, {"reason", "no device"}, {"levels", json::array()}});
  return row;
}

class GoldenReport : public RowsReport {
protected:
  GoldenReport() : RowsReport("golden", golden_row("openmp")) {}
};

TEST_F(GoldenReport, NamesTheBackendsThatHaveTheHash) {
  const std::string page =
      page_of(rows(golden_row("scalar"), golden_row("openmp"), skipped_row("gl-compute")));
  EXPECT_THAT(page, HasSubstr("&lt;square&gt;<small>257"));
  EXPECT_THAT(page, HasSubstr("<code>00000000000000bb</code>"));
  EXPECT_THAT(page, HasSubstr("<b>✓</b> scalar, openmp</div>"));
  EXPECT_THAT(page, HasSubstr("<b>– skipped:</b> gl-compute</div>"));
  EXPECT_THAT(page, HasSubstr("Every level of 2 solutions has the hash"));
}

TEST_F(GoldenReport, ADifferenceIsSaidAtTheTop) {
  const std::string page = page_of(rows(golden_row("scalar"), differing_row("openmp")));
  EXPECT_THAT(page, HasSubstr("<div class=\"verdict bad\">\n<p class=\"sentence\">1 of 2"));
  EXPECT_THAT(page, HasSubstr("<b>✗</b> openmp<small>openmp: level 1: 1 &amp; not 2</small>"));
}

TEST_F(GoldenReport, OtherInputsAreUnsure) {
  json row = golden_row("scalar");
  row.update({{"verdict", "mistrusted"}, {"inputs_reason", "libm"}, {"reason", "as scalar"}});
  const std::string page = page_of(rows(row));
  EXPECT_THAT(page, HasSubstr("no golden hashes to compare with"));
  EXPECT_THAT(page, HasSubstr("✗ inputs:</b> libm"));
  EXPECT_THAT(page, Not(HasSubstr("Every level")));
}

TEST_F(GoldenReport, ContradictionsAreRefused) {
  expect_refused({{"/first_difference", 1, "a level differs"},
                  {"/levels", json::array(), "there is no level"},
                  {"/inputs_reason", "libm", "inputs"},
                  {"/verdict", "maybe", "verdict"},
                  {"/levels", missing, "levels"}});
}

} // namespace
} // namespace hdmbench
