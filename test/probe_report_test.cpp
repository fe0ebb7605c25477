// What the page says about the arithmetic of devices.

#include "test/report_samples.hpp"

namespace hdmbench::report_samples {
namespace {

json probe_row(const std::string& backend, const std::string& question) {
  json row =
      json::parse(R"({"device": "llvmpipe", "driver": "Mesa", "program": "sweep", "as_specified": "kept",
    "otherwise": "flushed to 0", "answer": "as specified", "telling": 16, "specified": 16, "other": 0, "ulp": null,
    "agreement_needs_it": false})");
  row.update({{"backend", backend}, {"question", question}});
  return row;
}

json flushed(json row) {
  row.update({{"answer", "otherwise"}, {"specified", 0}, {"other", 16}});
  return row;
}

class ProbeReport : public RowsReport {
protected:
  ProbeReport() : RowsReport("probe", probe_row("gl-compute", "subnormal + 0")) {}
};

TEST_F(ProbeReport, HasAColumnForEachBackendAndTheTierToExpect) {
  json own = probe_row("gl-compute", "exp(a)");
  own.update({{"program", "GLSL 4.30"}, {"answer", "mixed"}, {"specified", 4}, {"other", 12}, {"ulp", 7.89}});
  const std::string page = page_of(rows(probe_row("gl-compute", "subnormal + 0"), own,
                                        flushed(probe_row("gl-fragment", "subnormal + 0"))));
  EXPECT_THAT(page, HasSubstr("<td class=\"agree\">kept</td><td class=\"mistrusted\">flushed to 0</td>"));
  EXPECT_THAT(page, HasSubstr("up to 7.89 ulp off, 4 of 16 correct"));
  EXPECT_THAT(page, HasSubstr("<td class=\"skipped\">not asked</td>"));
  EXPECT_THAT(page, HasSubstr("numbers below 1e-38 may be taken for 0"));
}

TEST_F(ProbeReport, WhatAgreementNeedsIsRed) {
  json row = flushed(probe_row("gl-compute", "a * b + c, candidates"));
  row.update({{"otherwise", "fused"}, {"agreement_needs_it", true}});
  const std::string page = page_of(rows(row));
  EXPECT_THAT(page, HasSubstr("<td class=\"disagree\">fused</td>"));
  EXPECT_THAT(page, HasSubstr("certified: a * b + c, candidates: fused"));
}

TEST_F(ProbeReport, RowsOfBeforeHaveNoProgram) {
  json row = probe_row("gl-compute", "subnormal + 0");
  row.erase("program");
  row.erase("ulp");
  EXPECT_THAT(page_of(rows(row)), HasSubstr("<td>sweep</td><th scope=\"row\">subnormal + 0</th>"));
}

TEST_F(ProbeReport, ContradictionsAreRefused) {
  expect_refused({{"/specified", 3, "not every telling component says so"},
                  {"/answer", "perhaps", "answer"},
                  {"/telling", missing, "telling"}});
}

TEST_F(ProbeReport, WithoutRowsItSaysWhatToType) {
  EXPECT_THAT(render(document("bench", rows(bench_row("openmp", "square", 300, 1.0, 1.0)))),
              HasSubstr("hdmbench probe --json FILE"));
}

} // namespace
} // namespace hdmbench::report_samples
