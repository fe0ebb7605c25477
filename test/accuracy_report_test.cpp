#include "test/accuracy_samples.hpp"

#include <map>
#include <regex>
#include <string>

namespace hdmbench {
namespace {

using namespace report_samples;

class AccuracyReport : public RowsReport {
protected:
  AccuracyReport() : RowsReport("accuracy", with_all_figures(accuracy_row("icm", "scalar"))) {}
  void SetUp() override {
    RowsReport::SetUp();
    write_text("f.png", figure_picture());
  }

  // The second box at the top of the page.
  static std::string accuracy_verdict(const std::string& page) {
    const std::size_t first = page.find("<div class=\"verdict");
    return verdict(page.substr(first + 1));
  }
};

// From a heading or summary to the next one.
std::string part(const std::string& page, const std::string& start) {
  const std::size_t from = page.find(start);
  EXPECT_NE(from, std::string::npos) << start;
  return from == std::string::npos ? ""
                                   : page.substr(from, page.find("<summary>", from + start.size()) - from);
}

TEST_F(AccuracyReport, TheVerdictHasItsFigures) {
  const std::string box = accuracy_verdict(page_of(accuracy_rows()));
  EXPECT_THAT(box, HasSubstr("verdict good"));
  EXPECT_THAT(box, HasSubstr("ICM is 0.500 px (RMSD) from finite elements on square."));
  EXPECT_THAT(
      box,
      HasSubstr("float32 chose otherwise than double in 6 of 8\u202F642 steps of 2 runs, each a near-tie"));
  EXPECT_THAT(box, HasSubstr("in 6 decompositions; the worst remainder is 0.0e+00 px²."));
}

TEST_F(AccuracyReport, MethodsOfTheElasticEnergyHaveLines) {
  json row = accuracy_row("conjugate-gradients", "openmp");
  row.update({{"energy", "elastic"}, {"rmsd_to_fem", 2.5e-6}});
  json wrong = row;
  wrong["energy"] = "plastic";
  EXPECT_THAT(error_of(document("accuracy", rows(wrong))), HasSubstr("must be one of: none, hdm, elastic"));
  const std::string page = page_of(rows(fem_row(0.3), row));
  EXPECT_THAT(page, HasSubstr("elastic, conjugate gradients"));
  EXPECT_THAT(page, HasSubstr("2.5e-06<small>free 0.875</small>"));
}

TEST_F(AccuracyReport, AStepBeyondTheBoundIsBad) {
  json results = accuracy_rows();
  results[1]["arithmetic"]["resynchronised"].update({{"beyond_bound", 2}, {"largest_gap_over_bound", 1.75}});
  const std::string page = page_of(results);
  EXPECT_THAT(accuracy_verdict(page), HasSubstr("verdict bad"));
  EXPECT_THAT(accuracy_verdict(page),
              HasSubstr("sentence\">float32 leaves the derived bound in 2 steps: openmp on square."));
  EXPECT_THAT(part(page, "<details open><summary>Single against double precision"), HasSubstr("✗ 2"));
}

TEST_F(AccuracyReport, NothingComparedIsNotGood) {
  json results = accuracy_rows();
  results[0]["arithmetic"]["resynchronised"] = json::parse(
      R"({"iterations": 0, "steps_compared": 0, "steps_differing": 0, "largest_gap_over_bound": null,
        "rmsd": null, "beyond_bound": 0})");
  EXPECT_THAT(accuracy_verdict(page_of(results)), HasSubstr("verdict unsure"));
  results[0].erase("arithmetic");
  results[1].erase("arithmetic");
  const std::string box = accuracy_verdict(page_of(results));
  EXPECT_THAT(box, HasSubstr("verdict unsure"));
  EXPECT_THAT(box, HasSubstr("float32 was not compared with double."));
}

TEST_F(AccuracyReport, FailuresAreShownAndNeverFolded) {
  json results = accuracy_rows();
  results[1].update({{"valid", false}}); // the same figures as row 0, but other bits than scalar
  results[8].update({{"status", "the pictures are blank"},
                     {"valid", false},
                     {"seconds", json::array()},
                     {"seconds_median", nullptr},
                     {"mean_energy", nullptr},
                     {"rmsd_to_fem", nullptr}});
  const std::string page = page_of(results);
  EXPECT_EQ(occurrences(part(page, "<details open><summary>square"), "✗ failed"), 2U);
  EXPECT_THAT(page, HasSubstr("✗ failed</b><small>the pictures are blank</small>"));
  EXPECT_THAT(page, HasSubstr("✗ failed</b><small>not finite, or not the bits of scalar</small>"));
  const std::string box = accuracy_verdict(page);
  EXPECT_THAT(box, HasSubstr("verdict bad"));
  EXPECT_THAT(box, HasSubstr("sentence\">2 of 9 results failed: icm by openmp on square: not finite"));
  EXPECT_THAT(box, HasSubstr("; b-spline on square: the pictures are blank."));
}

TEST_F(AccuracyReport, AMissingResultAloneIsUnsure) {
  json results = accuracy_rows();
  results[6].update({{"status", "too little memory"}, {"valid", false}});
  for (const char* const key :
       {"mean_energy", "rmsd_to_fem", "seconds", "seconds_median", "rmsd_to_fem_nu0"}) {
    results[6].erase(key);
  }
  const std::string page = page_of(results);
  EXPECT_THAT(accuracy_verdict(page), HasSubstr("verdict unsure"));
  EXPECT_THAT(accuracy_verdict(page),
              HasSubstr("sentence\">1 of 9 results failed: fem-coarse on square: too little memory."));
}

TEST_F(AccuracyReport, ARegistrationThatWentAstrayIsMarkedButNoFaultOfOurs) {
  json results = accuracy_rows();
  results[8].update({{"status", "went astray: 71.2 px from finite elements"}, {"valid", false}});
  const std::string page = page_of(results);
  EXPECT_THAT(page, HasSubstr("✗ failed</b><small>went astray: 71.2 px"));
  EXPECT_THAT(accuracy_verdict(page), HasSubstr("verdict unsure"));
  EXPECT_THAT(accuracy_verdict(page), HasSubstr("b-spline on square: went astray: 71.2 px"));
}

TEST_F(AccuracyReport, SkippedIsNoFailureButSaid) {
  json results = accuracy_rows();
  json skipped = accuracy_row("icm", "vulkan-compute");
  skipped.update({{"status", "skipped: no Vulkan driver"}, {"valid", false}});
  for (const char* const key : {"mean_energy", "rmsd_to_fem", "seconds", "seconds_median", "rmsd_to_fem_nu0",
                                "levels", "iterations", "decompositions"}) {
    skipped.erase(key);
  }
  results.push_back(skipped);
  const std::string page = page_of(results);
  EXPECT_THAT(accuracy_verdict(page), HasSubstr("verdict good"));
  EXPECT_THAT(accuracy_verdict(page),
              HasSubstr("Skipped, so not judged: icm by vulkan-compute on square: skipped: no"));
  EXPECT_THAT(page, HasSubstr("– skipped</b><small>skipped: no Vulkan driver</small>"));
}

TEST_F(AccuracyReport, SaysWhereInterpolationIsNoWorse) {
  json results = accuracy_rows();
  EXPECT_THAT(accuracy_verdict(page_of(results)), HasSubstr("on 0 of 1 scene; not on square."));
  results[7]["rmsd_to_fem_nu0"] = 4.0;
  json other = accuracy_row("icm", "scalar", "circular");
  other["rmsd_to_fem_nu0"] = 37.03;
  results.push_back(other);
  const std::string box = accuracy_verdict(page_of(results));
  EXPECT_THAT(box, HasSubstr("than interpolation, which knows no material, on 1 of 1 scene."));
  EXPECT_THAT(
      box,
      HasSubstr("ICM is 0.500 px (square) to 37.0 px (circular) from finite elements: RMSD on 2 scenes."));
}

TEST_F(AccuracyReport, EveryFigureAppears) {
  const std::string page = page_of(accuracy_rows_with_figures());
  const std::map<std::string, std::string> shown{
      {"Error by source: model and optimisation", "class=\"optimisation\" style=\"width:"},
      {"Profiles against FEM", "Thesis: Fig. 5.5."},
      {"Difference to FEM", "ICM, simultaneous minus FEM, ν\u00A0=\u00A00"},
      {"Convergence", "Thesis: Fig. 5.3b."},
      {"Displacement on each level", "Thesis: Figs. 5.6 and 5.7."},
      {"Deformed grids", "<path class=\"lines\" d=\"M0 0l10 0 23-10M0 20l30 0\"/>"},
      {"Error at material interfaces", "<td class=\"number\">2.00</td>"},
      {"Single against double precision", "<td class=\"number\">0.25</td>"}};
  for (const auto& [summary, content] : shown) {
    EXPECT_THAT(part(page, "<summary>" + summary), HasSubstr(content));
  }
  // Trade-off, 4 profiles, convergence, iterations, 2 levels x 2 directions, 3 grids.
  EXPECT_EQ(occurrences(page, "<svg"), 14U);
  EXPECT_EQ(occurrences(page, "src=\"data:image/png;base64,"), 3U);
  EXPECT_EQ(occurrences(page, "class=\"ramp signed\""), 2U);
  EXPECT_THAT(part(page, "Error by source"), HasSubstr("class=\"minus\""));
  EXPECT_THAT(page, Not(HasSubstr("not shown on this page")));
}

TEST_F(AccuracyReport, RowsWithoutFiguresWork) {
  json bare = accuracy_row("icm", "scalar", "mine");
  for (const char* const key : {"decompositions", "levels", "rmsd_interface_to_fem", "rmsd_elsewhere_to_fem",
                                "interface_sites", "elsewhere_sites", "rmsd_to_fem", "rmsd_to_fem_nu0",
                                "rmsd_free_to_fem", "note", "variant", "device"}) {
    bare.erase(key);
  }
  bare["arithmetic"] = nullptr;
  bare["profiles"] = nullptr;
  const std::string page = page_of(rows(bare));
  EXPECT_THAT(page, HasSubstr("mine: A square"));
  EXPECT_EQ(occurrences(page, "<svg"), 0U);
  EXPECT_THAT(page, Not(HasSubstr("Profiles against FEM")));
  EXPECT_THAT(page, Not(HasSubstr("class=\"thesis\"")));
  EXPECT_THAT(render(document("verify", agreeing_rows())), HasSubstr("hdmbench accuracy --json FILE"));
}

TEST_F(AccuracyReport, PutsTheThesisBesideTheSameSizeOnly) {
  json row = accuracy_row("icm", "scalar");
  EXPECT_THAT(page_of(rows(row)), Not(HasSubstr("1.54026")));
  row.update({{"width", 300}, {"height", 300}});
  const std::string page = page_of(rows(row));
  EXPECT_THAT(page, HasSubstr("1.54026<small>ν not printed</small>"));
  EXPECT_THAT(page, HasSubstr("thesis, GPU<small>Table 5.1</small></th><td class=\"number\">0.00350</td>"));
}

TEST_F(AccuracyReport, BackendsWithTheSameFieldAreOneLine) {
  json results = accuracy_rows();
  results[1].update({{"seconds", {0.25}}, {"seconds_median", 0.25}});
  EXPECT_THAT(page_of(results), HasSubstr("same field by scalar 1.00\u00A0s, openmp 0.250\u00A0s"));
  EXPECT_THAT(page_of(results), HasSubstr("<td class=\"number\">0.250<small>openmp</small></td>"));
  results[1]["rmsd_to_fem_nu0"] = 0.5000001;
  EXPECT_THAT(page_of(results), Not(HasSubstr("same field by")));
}

TEST_F(AccuracyReport, VariantsStandBesideTheirPlainRun) {
  json variant = accuracy_row("icm", "scalar");
  variant.update(
      {{"variant", "start level 5"}, {"note", "Skips <coarse> levels."}, {"rmsd_to_fem_nu0", 0.125}});
  json results = accuracy_rows();
  results.push_back(variant);
  const std::string page = page_of(results);
  const std::string table = part(page, "<summary>Variants: what differs from the thesis");
  EXPECT_LT(table.find("ICM, simultaneous"),
            table.find("start level 5<small>Skips &lt;coarse&gt; levels.</small>"));
  EXPECT_THAT(table, HasSubstr(">0.125<"));
  EXPECT_THAT(accuracy_verdict(page), HasSubstr("ICM is 0.500 px")); // not the variant
}

TEST_F(AccuracyReport, SaysWhatTheThesisIsNear) {
  const auto at_300 = [](const char* method, const char* backend, double to_fem) {
    json row = accuracy_row(method, backend);
    row.update({{"width", 300}, {"height", 300}, {"rmsd_to_fem", to_fem}});
    return row;
  };
  const json plain = at_300("icm", "scalar", 0.3);
  json variant = plain;
  variant["variant"] = "start level 5";
  const auto page = [&](double interpolation) {
    return page_of(json::array({plain, variant, at_300("interpolation", "", interpolation)}));
  };
  EXPECT_THAT(page(1.6), HasSubstr("The thesis's 1.54 px (CPU) is about where interpolation ends"));
  EXPECT_THAT(page(3.0), Not(HasSubstr("is about where interpolation ends")));
}

TEST_F(AccuracyReport, NewerRowsReplaceOlderOnesUnlessTheTruthDiffers) {
  const auto written = [&](const char* name, json row, const char* date) {
    return write(name, document("accuracy", rows(std::move(row)), context("bench-1", date)));
  };
  json row = accuracy_row("icm", "scalar");
  const Path older = written("a.json", row, "2026-01-01T00:00:00Z");
  row["rmsd_to_fem_nu0"] = 0.25;
  const Path newer = written("b.json", row, "2026-02-01T00:00:00Z");
  row["poisson"] = 0.45;
  const Path other = written("c.json", row, "2026-02-02T00:00:00Z");
  row["variant"] = "start level 5";
  const Path variant = written("d.json", row, "2026-02-03T00:00:00Z");
  std::string page = render_files({newer, older});
  EXPECT_THAT(accuracy_verdict(page), HasSubstr("ICM is 0.250 px"));
  EXPECT_THAT(page, HasSubstr("1 row, 1 of them replaced by newer ones"));
  page = render_files({older, other, variant});
  EXPECT_THAT(page, Not(HasSubstr("replaced by newer ones")));
  EXPECT_THAT(accuracy_verdict(page),
              HasSubstr("ICM is 0.250 to 0.500 px (RMSD) from finite elements on square."));
  const Path fem = written("e.json", fem_row(0.3), "2026-01-01T00:00:00Z");
  const Path fem_nu0 = written("f.json", fem_row(0.0), "2026-02-01T00:00:00Z");
  EXPECT_THAT(render_files({fem, fem_nu0}), Not(HasSubstr("replaced by newer ones")));
}

TEST_F(AccuracyReport, EveryKeyHasItsType) {
  const json row = with_all_figures(accuracy_row("icm", "scalar"));
  for (const auto& [key, value] : row.items()) {
    if (key != "fine_sweep_equivalents") { // not on the page
      expect_refused({{"/" + key, json::array({json::object()}), "results.json: \"results[0]." + key}});
    }
  }
  for (const std::string key :
       {"scene", "title", "width", "height", "poisson", "method", "status", "valid"}) {
    expect_refused({{"/" + key, missing, "results.json: \"results[0]." + key + "\" is missing"}});
  }
}

TEST_F(AccuracyReport, RefusesWhatContradictsItself) {
  const std::string row = "results.json: \"results[0].";
  const std::string sweeps = "/arithmetic/resynchronised/";
  expect_refused({{"/rmsd_to_fem", -0.5, row + "rmsd_to_fem\" is -0.5, but must not be negative"},
                  {"/rmsd_elsewhere_to_fem", -1, "must not be negative"},
                  {"/decompositions/1/remainder", 1e-5, row + "decompositions[1].remainder\" is 1e-05 px^2"},
                  {"/decompositions/1/covariance", 0.125, row + "decompositions[1].remainder\" is -0.5 px^2"},
                  {"/decompositions/0/model", -1.0, "model\" is -1, but must not be negative"},
                  {"/convergence/mean_energy/-", 1, row + "convergence.mean_energy\" has 4 values, but"},
                  {"/convergence/rmsd_to_fem/1", -1, "has -1, but"},
                  {"/convergence/iterations_per_level", {10, 1, 50}, "must rise"},
                  {"/profiles/horizontal/-", 1, "has 5 values, but the width of the image is 4"},
                  {"/profiles/rising/-", 1, "profiles.rising\" has 5 values, but"},
                  {"/level_profiles/1/vertical/y",
                   {1, 2},
                   "level_profiles[1].vertical.y\" has 2 values, but the height of the level is 3"},
                  {"/iterations", 31, "levels\" come to 30 iterations, but \"iterations\" is 31"},
                  {"/grid/lines/0", {1, 2, 3}, "a line of 3 numbers"},
                  {"/differences/limit", 0, "must be greater than 0"},
                  {"/seconds_median", 9, "seconds_median\" is not between"},
                  {"/method", "magic", "must be one of: icm, sequential"},
                  {"/status", 3, "status\" must be a string"},
                  {"/method", "fem", "poisson_used\" is missing"},
                  {sweeps + "largest_gap_over_bound", 1.5, "is 1.5, but \"beyond_bound\" is 0"},
                  {sweeps + "beyond_bound", 4, "is 4, but only 3 steps differ"},
                  {sweeps + "steps_differing", 4322, "is 4322, but only 4321 were compared"}});
}

TEST_F(AccuracyReport, RefusesPicturesThatAreNotTheImage) {
  write_text("wide.png", std::string("\x89PNG\r\n\x1A\n\0\0\0\x0DIHDR\0\0\0\x05\0\0\0\x03", 24));
  expect_refused(
      {{"/differences/pictures/y", "gone.png", "gone.png"},
       {"/differences/pictures/x", "wide.png", "wide.png: has 5 x 3 pixels, but the image has 4 x 3 sites"}});
  json longer = with_profiles(accuracy_row("fixed-point"));
  longer["profiles"].update({{"falling", {1, 2, 3, 4, 5}}, {"rising", {1, 2, 3, 4, 5}}});
  EXPECT_THAT(error_of(document("accuracy", rows(with_profiles(fem_row(0.3)), longer))),
              HasSubstr("square: the falling profile of fixed point has 5 values"));
}

TEST_F(AccuracyReport, GapsAndFlatCurvesAreDrawn) {
  json row = with_all_figures(accuracy_row("icm", "scalar"));
  row["profiles"]["horizontal"] = {nullptr, nullptr, nullptr, nullptr};
  row["profiles"]["vertical"] = {0, 0, 0};
  row["convergence"] =
      json::parse(R"({"iterations_per_level": [5], "rmsd_to_fem": [0], "rmsd_to_fixed_point": [0],
    "mean_energy": [0]})");
  EXPECT_EQ(occurrences(page_of(rows(row, with_profiles(fem_row(0.3)))), "<svg"), 1U + 4U + 1U + 4U + 1U);
}

TEST_F(AccuracyReport, EscapesEveryText) {
  const std::string evil = "<script>alert(\"1\")</script>&'`\nsystem('x')";
  json results = accuracy_rows_with_figures();
  for (json& row : results) {
    row.update({{"scene", evil}, {"title", evil}, {"note", evil}, {"device", evil}});
    row["backend"] = row["backend"] == "" ? "" : evil;
  }
  results[0]["differences"]["against"] = evil;
  json variant = accuracy_row("icm", evil, evil);
  variant.update({{"variant", evil}, {"note", evil}});
  json failed = accuracy_row("icm", "other", evil);
  failed.update({{"status", evil}, {"valid", false}});
  results.push_back(variant);
  results.push_back(failed);
  const std::string page = page_of(results);
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(HasSubstr("alert(\"")));
  EXPECT_GT(occurrences(page, "&lt;script&gt;alert(&quot;1&quot;)&lt;/script&gt;&amp;&#39;"), 10U);
}

TEST_F(AccuracyReport, LoadsNothingAndIdsAreUnique) {
  json results = accuracy_rows_with_figures();
  for (json row : accuracy_rows_with_figures()) {
    row["scene"] = "circular";
    results.push_back(row);
  }
  const std::string page = render_files({write("a.json", document("accuracy", results)),
                                         write("b.json", document("accuracy", results, context("bench-2")))});
  const std::regex reference("(?:src|href|srcset|data|action)\\s*=\\s*[\"']([^\"']*)");
  for (std::sregex_iterator match(page.begin(), page.end(), reference), end; match != end; ++match) {
    const std::string target = (*match)[1];
    EXPECT_TRUE(target.starts_with("#") || target.starts_with("data:image/png;base64,")) << target;
  }
  EXPECT_THAT(page, Not(HasSubstr("://")));
  EXPECT_THAT(page, Not(HasSubstr("url(")));
  std::map<std::string, int> ids;
  const std::regex id("\\sid\\s*=\\s*[\"']([^\"']*)");
  for (std::sregex_iterator match(page.begin(), page.end(), id), end; match != end; ++match) {
    EXPECT_EQ(++ids[(*match)[1]], 1) << (*match)[1];
  }
}

} // namespace
} // namespace hdmbench
