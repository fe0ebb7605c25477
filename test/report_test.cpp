#include "test/report_samples.hpp"

#include <map>
#include <regex>
#include <string>
#include <vector>

namespace hdmbench {
namespace {

using namespace report_samples;

class ReportPage : public ReportFolder {};

TEST_F(ReportPage, SaysThatAllAgree) {
  const std::string box = verdict(render(document("verify", agreeing_rows())));
  EXPECT_THAT(box, HasSubstr("verdict good"));
  EXPECT_THAT(
      box,
      HasSubstr("All 2 backends on this machine agree with scalar to the last bit in 4 of 4 comparisons."));
}

TEST_F(ReportPage, NamesWhatDisagrees) {
  json checks = agreeing_rows();
  checks[2] = disagreeing(checks[2]);
  checks[2].update({{"counts_differing", 2}, {"not_finite", 1}});
  checks[2]["first_difference"].update({{"found", {0.1, nullptr}}});
  const std::string page = render(document("verify", checks));
  EXPECT_THAT(
      page,
      HasSubstr("7 sites differ, 1 not finite, the number of changed sites is wrong after 2 iterations"));
  EXPECT_THAT(page, HasSubstr("found (0.1, not finite)"));
  EXPECT_THAT(verdict(page), HasSubstr("verdict bad"));
  EXPECT_THAT(verdict(page),
              HasSubstr("1 of 4 comparisons disagrees with scalar on this machine: gl-fragment on square."));
  EXPECT_THAT(page, HasSubstr("level 2, iteration 17, site (3, 4)"));
  EXPECT_THAT(page, Not(HasSubstr("All 2 backends")));
}

TEST_F(ReportPage, SkippedIsNeverAPass) {
  json checks = agreeing_rows();
  checks.push_back(skipped(verify_row("vulkan-compute", "resync"), "no Vulkan driver"));
  checks.push_back(skipped(verify_row("vulkan-compute", "free"), "no Vulkan driver"));
  const std::string page = render(document("verify", checks));
  EXPECT_THAT(verdict(page), HasSubstr("All 2 backends that were compared on this machine agree"));
  EXPECT_THAT(verdict(page), HasSubstr("4 of 4 comparisons"));
  EXPECT_THAT(verdict(page),
              HasSubstr("Skipped, so not checked: vulkan-compute, 2 comparisons (no Vulkan driver)."));
  EXPECT_THAT(page, HasSubstr("– skipped"));
}

TEST_F(ReportPage, ModesThatSayTheSameAreOneLine) {
  json checks = rows(verify_row("openmp", "resync"), verify_row("openmp", "free"),
                     verify_row("openmp", "active"), disagreeing(verify_row("openmp", "pyramid")));
  EXPECT_THAT(render(document("verify", checks)), HasSubstr("resync, free, active: 0 sites differ"));
  EXPECT_THAT(render(document("verify", checks)), HasSubstr("pyramid: 7 sites differ"));
  checks = rows(verify_row("openmp", "windows"));
  EXPECT_THAT(render(document("verify", checks)), HasSubstr("windows: 0 sites differ"));
}

TEST_F(ReportPage, AllSkippedIsNotGood) {
  const std::string box = verdict(
      render(document("verify", rows(skipped(verify_row("vulkan-compute", "free"), "no Vulkan driver")))));
  EXPECT_THAT(box, Not(HasSubstr("verdict good")));
  EXPECT_THAT(box, HasSubstr("Nothing was cross-checked"));
}

TEST_F(ReportPage, MistrustedIsNotGood) {
  json checks = agreeing_rows();
  checks[0].update({{"verdict", "mistrusted"}, {"tier", "none"}, {"reason", "no site moved"}});
  const std::string box = verdict(render(document("verify", checks)));
  EXPECT_THAT(box, HasSubstr("verdict unsure"));
  EXPECT_THAT(box, HasSubstr("1 of 4 cannot be trusted: openmp on square."));
  EXPECT_THAT(box, HasSubstr("3 of 4 comparisons agree."));
  EXPECT_THAT(box, HasSubstr("no site moved"));
}

TEST_F(ReportPage, CertifiedIsSaidApart) {
  json checks = agreeing_rows();
  checks[0].update(
      {{"verdict", "certified"}, {"tier", "certified"}, {"sites_differing", 2}, {"certified_ties", 2}});
  const std::string box = verdict(render(document("verify", checks)));
  EXPECT_THAT(
      box,
      HasSubstr("4 of 4 comparisons, 3 to the last bit and 1 with every difference a certified near-tie"));
}

TEST_F(ReportPage, EveryMethodHasALineOfItsOwn) {
  json checks = agreeing_rows();
  for (std::size_t i = 0; i < 2; ++i) { // openmp's; as files without methods, and icm, are the same
    json other = checks[i];
    checks[i]["method"] = "icm";
    other["method"] = "cascade";
    checks.push_back(other);
  }
  const std::string page = render(document("verify", checks));
  EXPECT_THAT(page, HasSubstr(", cascade</small>"));
  EXPECT_THAT(page, Not(HasSubstr(", icm</small>")));
  EXPECT_THAT(page, HasSubstr("not compared")) << "gl-fragment by cascade";
}

TEST_F(ReportPage, TheTierOfABackendIsItsLowest) {
  json checks = agreeing_rows();
  checks[0].update({{"tier", "exact"}});
  EXPECT_THAT(render(document("verify", checks)), HasSubstr("<td class=\"agree\"><b>✓ bitwise</b>"));
  EXPECT_THAT(render(document("verify", checks)), Not(HasSubstr("<td class=\"agree\"><b>✓ exact</b>")));
  checks[0].update(
      {{"verdict", "certified"}, {"tier", "certified"}, {"sites_differing", 2}, {"certified_ties", 2}});
  EXPECT_THAT(render(document("verify", checks)), HasSubstr("<td class=\"certified\"><b>≈ certified</b>"));
  checks[0].update({{"verdict", "disagree"}, {"tier", "none"}, {"uncertified", 1}});
  EXPECT_THAT(render(document("verify", checks)), HasSubstr("<td class=\"disagree\"><b>✗ none</b>"));
}

TEST_F(ReportPage, NamesBackendsThatWereNeverCompared) {
  const Path devices =
      write("devices.json", document("devices", rows(device_row("scalar", true), device_row("openmp", true),
                                                     device_row("gl-compute", true))));
  const Path verify = write("verify.json", document("verify", agreeing_rows()));
  EXPECT_THAT(verdict(render_files({devices, verify})), HasSubstr("Never compared: gl-compute."));
}

TEST_F(ReportPage, SupportMatrixHasTheReason) {
  const std::string page =
      render(document("devices", rows(device_row("vulkan-compute", false, "no Vulkan driver"))));
  EXPECT_THAT(
      page,
      HasSubstr("<td class=\"skipped\">no</td><td class=\"skipped\" colspan=\"4\">no Vulkan driver</td>"));
  EXPECT_THAT(verdict(page), HasSubstr("Nothing was cross-checked"));
}

TEST_F(ReportPage, HasALineForADriverThatHangs) {
  json passed = json::parse(R"({"backend": "gl-fragment", "implementation": "softpipe", "device": "softpipe",
    "driver": "OpenGL 3.3", "outcome": "passed", "tier": "bitwise", "scenes": 14, "comparisons": 56,
    "sites_compared": 1234567, "sites_differing": 0, "seconds": 12.5, "peak_bytes": 870000000, "reason": "",
    "repeat": "hdmbench verify"})");
  json hangs = passed;
  hangs.update(json::parse(R"({"implementation": "other", "outcome": "out of time", "tier": "none",
    "comparisons": 0, "reason": "ended after 180 s"})"));
  const std::string page = render(document("implementations", rows(passed, hangs)));
  EXPECT_THAT(page, HasSubstr("<td class=\"agree\">bitwise</td>"));
  EXPECT_THAT(page, HasSubstr("870 MB"));
  EXPECT_THAT(page, HasSubstr("<td class=\"disagree\">out of time</td><td colspan=\"5\">ended after 180 s"));
  passed["comparisons"] = 0;
  EXPECT_THROW(render(document("implementations", rows(passed))), InputError);
}

TEST_F(ReportPage, SaysWhatWasChosenByMeasurement) {
  json device = device_row("gl-compute", true);
  device["choices"] = json::parse(R"([{"what": "coarse levels", "chosen": "one dispatch",
      "options": [{"name": "a dispatch per sweep", "seconds": [0.004, 0.003]},
                  {"name": "one dispatch", "seconds": [0.002]}]}])");
  EXPECT_THAT(render(document("devices", rows(device))),
              HasSubstr("coarse levels: a dispatch per sweep 3.50 ms, one dispatch 2.00 ms: one dispatch."));
  device["choices"][0]["chosen"] = "neither";
  EXPECT_THROW(render(document("devices", rows(device))), InputError);
}

TEST_F(ReportPage, PartsWithoutDataNameTheirCommand) {
  const std::string page = render(document("verify", agreeing_rows()));
  for (const char* const command :
       {"hdmbench devices --json FILE", "hdmbench bench --json FILE", "hdmbench run SCENE --json FILE",
        "hdmbench implementations --json FILE", "hdmbench atlas --json FILE", "hdmbench accuracy --json FILE",
        "hdmbench faults --json FILE", "hdmbench golden --json FILE",
        "hdmbench bench --compare OLD.json --json", "test/failing_calls --json FILE",
        "instruction_count --json"}) {
    EXPECT_THAT(page, HasSubstr(command));
  }
}

TEST_F(ReportPage, EscapesEveryText) {
  const std::string evil = "<script>alert(\"1\")</script>&'";
  json where = context(evil);
  for (const char* const key :
       {"cpu", "operating_system", "compiler", "flags", "commit", "version", "arguments"}) {
    where[key] = evil;
  }
  json verify = disagreeing(verify_row(evil, "free", evil));
  verify.update({{"device", evil}, {"reason", evil}});
  json bench = bench_row(evil, evil, 300, 1.0, 2.0);
  bench.update({{"device", evil}, {"method", evil}});
  json unverified = bench_row("other", evil, 300, 1.0, 2.0);
  unverified.update({{"valid", false}, {"reason", evil}});
  json device = device_row(evil, true);
  device.update({{"device", evil}, {"driver", evil}, {"description", evil}});
  json run = run_row();
  run.update({{"scene", evil},
              {"title", evil},
              {"backend", evil},
              {"device", evil},
              {"method", evil},
              {"field", evil}});
  const std::string page =
      render_files({write("v.json", document("verify", rows(verify), where)),
                    write("b.json", document("bench", rows(bench, unverified), where)),
                    write("d.json", document("devices", rows(device, device_row("x", false, evil)), where)),
                    write("r.json", document("run", rows(run), where))});
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(HasSubstr("alert(\"")));
  EXPECT_GT(occurrences(page, "&lt;script&gt;alert(&quot;1&quot;)&lt;/script&gt;&amp;&#39;"), 20U);
}

TEST_F(ReportPage, LoadsNothingFromOutside) {
  const std::string page =
      render_files({write("v.json", document("verify", agreeing_rows())),
                    write("b.json", document("bench", rows(bench_row("openmp", "square", 300, 1.0, 2.0))))});
  const std::regex reference("(?:src|href|srcset|data|action)\\s*=\\s*[\"']([^\"']*)");
  int found = 0;
  for (std::sregex_iterator match(page.begin(), page.end(), reference), end; match != end; ++match, ++found) {
    const std::string target = (*match)[1];
    EXPECT_TRUE(target.starts_with("#") || target.starts_with("data:image/png;base64,")) << target;
  }
  EXPECT_GT(found, 5);
  EXPECT_THAT(page, Not(HasSubstr("://")));
  EXPECT_THAT(page, Not(HasSubstr("@import")));
  EXPECT_THAT(page, Not(HasSubstr("url(")));
}

TEST_F(ReportPage, IdsAreUniqueAndReferencesResolve) {
  json rows = json::array();
  for (const char* const scene : {"square", "circular", "my scene", "my-scene"}) {
    rows.push_back(bench_row("openmp", scene, 300, 1.0, 2.0));
    rows.push_back(bench_row("openmp", scene, 600, 4.0, 2.0));
  }
  const std::string page = render_files({write("a.json", document("bench", rows)),
                                         write("b.json", document("bench", rows, context("bench-2")))});
  std::map<std::string, int> ids;
  const std::regex id("\\sid\\s*=\\s*[\"']([^\"']*)");
  for (std::sregex_iterator match(page.begin(), page.end(), id), end; match != end; ++match) {
    EXPECT_EQ(++ids[(*match)[1]], 1) << (*match)[1];
  }
  EXPECT_EQ(occurrences(page, "<svg"), 16U); // seconds and throughput
  EXPECT_GT(ids.size(), 16U * 10U);          // every plot has at least its markers
  const std::regex reference("href\\s*=\\s*[\"']#([^\"']*)");
  for (std::sregex_iterator match(page.begin(), page.end(), reference), end; match != end; ++match) {
    EXPECT_EQ(ids.count((*match)[1]), 1U) << (*match)[1];
  }
}

TEST_F(ReportPage, PutsTheThesisBesideTheTimes) {
  const std::string page = render(document("bench", rows(bench_row("scalar", "square", 300, 2.0, 1.0),
                                                         bench_row("openmp", "square", 300, 0.25, 8.0))));
  EXPECT_THAT(page, HasSubstr("square, thesis Table 5.2"));
  EXPECT_THAT(page, HasSubstr(">0.250<small>0.225–0.275</small>"));
  EXPECT_THAT(page, HasSubstr(">8.00×<"));
  EXPECT_THAT(page, HasSubstr(">52.78×<"));
  EXPECT_THAT(page, HasSubstr(">1056.09<"));
}

TEST_F(ReportPage, UnverifiedTimesHaveNoSpeedUp) {
  json invalid = bench_row("gl-fragment", "square", 300, 0.125, 77.7);
  invalid.update({{"valid", false}, {"reason", "7 uncertified sites"}});
  json absent = bench_row("vulkan-compute", "square", 300, 1.0, 66.6);
  absent.update({{"valid", false},
                 {"reason", "no Vulkan driver"},
                 {"seconds", json::array()},
                 {"seconds_median", nullptr},
                 {"device", ""}});
  const std::string page =
      render(document("bench", rows(bench_row("openmp", "square", 300, 0.25, 8.0), invalid, absent)));
  EXPECT_THAT(page, Not(HasSubstr("77.7")));
  EXPECT_THAT(page, Not(HasSubstr("66.6")));
  EXPECT_THAT(page, HasSubstr("<td class=\"number best\">8.00×</td>"));
  EXPECT_THAT(page, HasSubstr("✗ not verified</b><small>7 uncertified sites"));
  EXPECT_THAT(page, HasSubstr("– skipped</b><small>no Vulkan driver"));
  const std::string plot = page.substr(page.find("<svg"), page.find("</svg>") - page.find("<svg"));
  EXPECT_THAT(plot, HasSubstr("openmp"));
  EXPECT_THAT(plot, Not(HasSubstr("gl-fragment")));
}

TEST_F(ReportPage, ADisagreementTakesTheSpeedUpBack) {
  const std::string page = render_files(
      {write("b.json", document("bench", rows(bench_row("gl-fragment", "square", 300, 0.125, 77.7)))),
       write("v.json", document("verify", rows(disagreeing(verify_row("gl-fragment", "free")))))});
  EXPECT_THAT(page, Not(HasSubstr("77.7")));
  EXPECT_THAT(page, HasSubstr("✗ not verified"));
}

TEST_F(ReportPage, QuickRunsSaySo) {
  json where = context();
  where["quick"] = true;
  EXPECT_THAT(render(document("verify", agreeing_rows(), where)), HasSubstr("--quick"));
}

TEST_F(ReportPage, NewerRowsReplaceOlderOnesOfTheSameMachine) {
  json checks = agreeing_rows();
  checks[0] = disagreeing(checks[0]);
  const Path older = write("a.json", document("verify", checks, context("bench-1", "2026-01-01T00:00:00Z")));
  const Path newer =
      write("b.json", document("verify", agreeing_rows(), context("bench-1", "2026-02-01T00:00:00Z")));
  const Path other =
      write("c.json", document("verify", agreeing_rows(), context("bench-2", "2026-02-01T00:00:00Z")));
  EXPECT_THAT(verdict(render_files({newer, older})), HasSubstr("4 of 4 comparisons"));
  EXPECT_THAT(verdict(render_files({older, other})), HasSubstr("1 of 8 comparisons disagrees"));
  EXPECT_THAT(render_files({newer, older}), HasSubstr("4 rows, 4 of them replaced by newer ones"));
}

TEST_F(ReportPage, TheSummaryFitsOnAScreen) {
  json checks;
  for (int i = 0; i < 50; ++i) { // a note each
    checks.push_back(skipped(verify_row("openmp", "free"), "reason " + std::to_string(i)));
    checks.back()["scene"] = "scene " + std::to_string(i);
  }
  checks.push_back(disagreeing(verify_row("gl-fragment", "free")));
  json unverified = bench_row("vulkan-compute", "square", 1200, 0.5, 66.6);
  unverified.update({{"valid", false}, {"reason", "7 uncertified sites"}, {"speed_up_over_scalar", nullptr}});
  const std::vector<Path> files{
      write("v.json", document("verify", checks)),
      write("b.json",
            document("bench", rows(bench_row("openmp", "square", 300, 0.25, 8.0),
                                   bench_row("openmp", "square", 1200, 4.75, 9.0),
                                   bench_row("gl-fragment", "square", 1200, 0.125, 77.7), unverified)))};
  const std::string text = summary_text(files);
  EXPECT_LE(occurrences(text, "\n"), 60U) << text;
  EXPECT_THAT(text,
              HasSubstr("1 of 1 comparison disagrees with scalar on this machine: gl-fragment on square."));
  EXPECT_THAT(text, HasSubstr("45 more notes on the page."));
  EXPECT_THAT(text, HasSubstr("4.75"));
  EXPECT_THAT(text, Not(HasSubstr("0.250"))) << "not the largest size";
  EXPECT_THAT(text, Not(HasSubstr("77.7"))) << "a wrong field has no speed-up";
  EXPECT_EQ(occurrences(text, "not verified"), 2U) << text;
}

TEST_F(ReportPage, EmbedsPictures) {
  // The head of a PNG of 2 x 1 pixels; the report reads no further.
  const std::string png("\x89PNG\r\n\x1A\n\0\0\0\x0DIHDR\0\0\0\x02\0\0\0\x01", 24);
  write_text("before.png", png);
  json row = run_row();
  row["pictures"] = {{"before", "before.png"}};
  const std::string page = render(document("run", rows(row)));
  EXPECT_THAT(
      page,
      HasSubstr("src=\"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAAB\" width=\"2\" height=\"1\" "
                "style=\"max-width:min(100%,4px)\""));
  EXPECT_THAT(page, HasSubstr("largest displacement 50 px = 25 mm"));

  std::filesystem::remove(folder_ / "page.html");
  row["pictures"] = {{"before", "gone.png"}};
  EXPECT_THAT(error_of(document("run", rows(row))), HasSubstr("gone.png"));
  write_text("text.png", "not a picture");
  row["pictures"] = {{"before", "text.png"}};
  EXPECT_THAT(error_of(document("run", rows(row))), HasSubstr("is not a PNG picture"));
}

} // namespace
} // namespace hdmbench
