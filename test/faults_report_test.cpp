#include "test/report_samples.hpp"

#include <string>

namespace hdmbench {
namespace {

using namespace report_samples;

json on_scene(const std::string& scene, const std::string& verdict, const std::string& reason = "") {
  return {{"scene", scene},
          {"width", 48},
          {"height", 40},
          {"method", "icm"},
          {"exact", scene == "ties"},
          {"verdict", verdict},
          {"sites_differing", verdict == "disagree" ? 7 : 0},
          {"uncertified", verdict == "disagree" ? 5 : 0},
          {"counts_differing", 0},
          {"reason", reason}};
}

json fault_row(const std::string& fault, const std::string& expected, bool caught, json scenes) {
  const bool as_expected = expected != "disagree" ? expected == "either" || !caught : caught;
  return {{"fault", fault},          {"what", "a <sign> is wrong"},
          {"backend", "gl-compute"}, {"device", "llvmpipe"},
          {"layer", "shader"},       {"expected", expected},
          {"caught", caught},        {"as_expected", as_expected},
          {"not_planted", ""},       {"scenes", std::move(scenes)}};
}

json caught_row() {
  return fault_row("sign", "disagree", true,
                   rows(on_scene("plain", "certified"), on_scene("ties", "disagree")));
}

class FaultsReport : public RowsReport {
protected:
  FaultsReport() : RowsReport("faults", caught_row()) {}
};

TEST_F(FaultsReport, SaysWhereAFaultWasCaught) {
  const std::string page = page_of(
      rows(caught_row(), fault_row("fused", "let through", false, rows(on_scene("plain", "certified")))));
  EXPECT_THAT(page, HasSubstr("1 of 1 planted faults caught, 1 of 1 controls let through."));
  EXPECT_THAT(page, HasSubstr("a &lt;sign&gt; is wrong"));
  EXPECT_THAT(page, HasSubstr("<td class=\"certified\""));
  EXPECT_THAT(page, HasSubstr("<td class=\"agree\" title=\"7 differing, 5 uncertified\">disagree</td>"));
  EXPECT_THAT(page, HasSubstr("✓ caught"));
  EXPECT_THAT(page, HasSubstr(", exact"));
  EXPECT_THAT(page, HasSubstr("1 of the faults only where every number is exact"));
  EXPECT_THAT(page, Not(HasSubstr("✗ not caught")));
}

TEST_F(FaultsReport, SaysWhatWasNotCaught) {
  json unplanted = fault_row("typo", "disagree", false, rows(on_scene("plain", "agree")));
  unplanted["not_planted"] = "\"x\" is not in the shader";
  const std::string page =
      page_of(rows(caught_row(), fault_row("blind", "disagree", false, rows(on_scene("plain", "agree"))),
                   unplanted, fault_row("fused", "let through", true, rows(on_scene("plain", "disagree")))));
  EXPECT_THAT(page, HasSubstr("1 of 3 planted faults caught, 0 of 1 controls let through."));
  EXPECT_THAT(page, HasSubstr("✗ not caught"));
  EXPECT_THAT(page, HasSubstr("✗ not let through"));
  EXPECT_THAT(page, HasSubstr("not planted<small class=\"reason\">&quot;x&quot; is not in the shader"));
}

TEST_F(FaultsReport, WhatWasNotRunCountsForNothing) {
  json skipped = fault_row("sign", "disagree", false, rows(on_scene("plain", "skipped", "no libEGL")));
  skipped["as_expected"] = true;
  const std::string page = page_of(rows(skipped));
  EXPECT_THAT(page, HasSubstr("0 of 0 planted faults caught"));
  EXPECT_THAT(page, HasSubstr("1 mistake not run"));
}

TEST_F(FaultsReport, ContradictionsAreRefused) {
  expect_refused({{"/scenes/1/verdict", "agree", "although verify disagrees on no scene"},
                  {"/caught", false, "although verify disagrees on a scene"},
                  {"/not_planted", "why", "as_expected"},
                  {"/expected", "let through", "as_expected"},
                  {"/what", missing, "what"},
                  {"/scenes/0/verdict", "perhaps", "verdict"}});
}

} // namespace
} // namespace hdmbench
