// What the page of results says of rows, and what it carries.

#include "backends/shared/subprocess.hpp"
#include "test/page_samples.hpp"

#include <vector>

namespace hdmbench {
namespace {

using namespace page_samples;

/// What the rows of a command come to beside a good row of verify.
struct Case {
  const char* command;
  json row;
  report::State state;
  const char* says;
};

TEST_F(Page, VerdictsAreTheWorstThatWasFound) {
  using enum report::State;
  const json fault = {{"fault", "drift"},
                      {"backend", "openmp"},
                      {"as_expected", true},
                      {"scenes", {{{"scene", "square"}, {"verdict", "disagree"}}}}};
  const auto with = [](json row, const json& changes) {
    row.update(changes);
    return row;
  };
  const json timing = bench_row("openmp", 300, 0.1, 10.0);
  const json request = point("as-needed-elastic", 0.1, 0.005, {{"asked", 0.01}, {"estimated_error", 0.006}});
  const std::vector<Case> cases{
      {"verify", verify_row("opencl"), good,
       "All 2 backends agree with scalar in 2 of 2 comparisons, to the last bit."},
      {"verify", verify_row("opencl", {{"verdict", "certified"}, {"sites_differing", 3}}), good,
       "in 1 of them with each difference certified"},
      {"verify", verify_row("opencl", {{"verdict", "disagree"}, {"sites_differing", 1}}), bad,
       "1 of 2 comparisons disagree with scalar: opencl on square."},
      {"verify", verify_row("opencl", {{"sites_differing", 1}}), bad, "disagree"},
      {"verify", verify_row("opencl", {{"counts_differing", 1}}), bad, "disagree"},
      {"verify", verify_row("opencl", {{"sites_compared", 0}}), bad, "disagree"},
      {"verify", verify_row("opencl", {{"verdict", "certified"}, {"uncertified", 1}}), bad, "disagree"},
      {"verify", verify_row("opencl", {{"verdict", "mistrusted"}}), unsure, "cannot be trusted"},
      {"verify", verify_row("opencl", {{"verdict", "skipped"}, {"reason", "no device"}}), unsure,
       "Skipped, so not checked: opencl on square (no device)."},
      {"verify", verify_row("opencl", {{"verdict", "splendid"}}), unsure, "Skipped, so not checked"},
      {"verify", verify_row("openmp", {{"verdict", "skipped"}, {"mode", "active"}}), good,
       "1 comparison does not apply"},
      {"devices",
       {{"backend", "opencl"}, {"available", false}, {"reason", "no driver"}},
       unsure,
       "opencl was not compared: no driver."},
      {"golden", verify_row("openmp"), good, "1 solution has the hashes"},
      {"golden", verify_row("openmp", {{"verdict", "disagree"}}), bad, "have not the golden hashes"},
      {"golden", verify_row("openmp", {{"verdict", "mistrusted"}}), unsure, "no golden hashes"},
      {"golden", verify_row("openmp", {{"first_difference", 3}}), bad, "have not the golden hashes"},
      {"implementations",
       {{"backend", "gl-compute"}, {"implementation", "zink"}, {"outcome", "passed"}},
       good,
       "1 backend on other drivers"},
      {"implementations",
       {{"backend", "gl-compute"}, {"implementation", "zink"}, {"outcome", "failed"}},
       bad,
       "gl-compute on zink"},
      {"implementations",
       {{"backend", "gl-compute"}, {"implementation", "zink"}, {"outcome", "crashed"}},
       unsure,
       "gave no answer"},
      {"implementations",
       {{"backend", "gl-compute"}, {"implementation", "zink"}, {"outcome", "absent"}},
       good,
       ""},
      {"faults", fault, good, "1 planted fault"},
      {"faults", with(fault, {{"as_expected", false}}), bad, "drift on openmp"},
      {"faults", with(fault, {{"scenes", json::array()}}), unsure, "were not run"},
      {"faults", with(fault, {{"expected", "disagree"}, {"caught", false}}), bad, "drift on openmp"},
      {"failing-calls",
       {{"kind", "EGL_BAD_ALLOC"}, {"backend", "gl-fragment"}, {"failed", 7}, {"unclean", json::array()}},
       good,
       "7 failing calls"},
      {"failing-calls",
       {{"kind", "EGL_BAD_ALLOC"}, {"backend", "gl-fragment"}, {"failed", 7}, {"unclean", {{{"call", 3}}}}},
       bad,
       "EGL_BAD_ALLOC"},
      {"accuracy", point("icm", 0.1, 0.4, {{"arithmetic", {{"resynchronised", {{"beyond_bound", 2}}}}}}), bad,
       "leave the derived bound"},
      {"accuracy", point("icm", 0.1, 0.4, {{"valid", false}}), bad, "not scalar's"},
      {"accuracy", point("icm", 0.1, 0.4, {{"status", "out of memory"}}), unsure, "could not be judged"},
      {"accuracy", point("b-spline", 0.1, 0.4, {{"status", "failed"}, {"backend", ""}}), good,
       "of other solvers"},
      {"tradeoff", request, good, ""},
      {"tradeoff", with(request, {{"rmsd_to_fem_nu0", 0.02}}), bad,
       "0.01 px asked, 0.02 px reached by as-needed-elastic"},
      {"tradeoff", with(request, {{"rmsd_to_fem_nu0", 0.02}, {"estimated_error", 0.03}}), unsure,
       "and say so"},
      {"tradeoff", with(request, {{"poisson_used", 0.3}, {"rmsd_to_fem", 0.02}}), bad, "reached"},
      {"run", point("icm", 0.1, 0.1, {{"plan", {{"met", false}}}}), unsure, "do not reach"},
      {"bench", timing, good, ""},
      {"bench", with(timing, {{"valid", false}}), bad, "not scalar's"},
      {"bench", with(timing, {{"valid", nullptr}}), good, "1 timing was not checked"},
  };
  for (const Case& one : cases) {
    SCOPED_TRACE(std::string(one.command) + " " + one.row.dump());
    write("verify.json", "verify", json::array({verify_row("openmp")}));
    write("more.json", one.command, json::array({one.row}));
    const report::Verdict found = verdict();
    EXPECT_EQ(name_of(found.state), name_of(one.state));
    std::string all = found.sentence;
    for (const report::Finding& note : found.notes) {
      all += '\n' + note.sentence;
    }
    EXPECT_THAT(one.state == good ? all : found.sentence, HasSubstr(one.says));
  }
  std::filesystem::remove(folder() / "verify.json");
  EXPECT_THAT(verdict().sentence, HasSubstr("there are no results of hdmbench verify"));
}

TEST_F(Page, NumbersBelowTheVerdictAreOfWhatWasVerified) {
  write("verify.json", "verify",
        json::array({verify_row("openmp"), verify_row("opencl", {{"verdict", "disagree"}})}));
  write("bench.json", "bench",
        json::array({bench_row("openmp", 300, 0.1, 10.0), bench_row("opencl", 300, 0.01, 100.0),
                     bench_row("scalar", 300, 1.0, 1.0)}));
  write("tradeoff.json", "tradeoff",
        json::array({point("fast", 0.001, 0.2), point("near", 0.002, 0.009), point("nearest", 0.5, 0.001),
                     point("wrong", 0.0001, 0.001, {{"valid", false}}),
                     point("fem", 0.0002, 0.0, {{"rival", true}})}));
  std::vector<std::string> values;
  for (const report::Figure& figure : verdict().figures) {
    values.push_back(std::string(name_of(figure.state)) + ": " + figure.value + ' ' +
                     figure.text.substr(0, 36));
  }
  EXPECT_THAT(values, ElementsAre("bad: 1 of 2 comparisons with scalar, the plain C",
                                  "good: 10 x as fast as plain C++ on one thread: ",
                                  "good: 0.009 px from finite elements after 2 ms: nea"));
}

TEST_F(Page, ANewerRowReplacesTheOlderOneOfTheSameComputation) {
  write("b.json", "verify",
        json::array({verify_row("openmp", {{"verdict", "disagree"}}), verify_row("opencl")}));
  write("a.json", "verify", json::array({verify_row("openmp")}), {{"date", "2026-11-24T01:02:03Z"}});
  EXPECT_EQ(verdict().sentence, "All 2 backends agree with scalar in 2 of 2 comparisons, to the last bit.");
  write("a.json", "verify", json::array({verify_row("openmp")}),
        {{"date", "2026-11-24T01:02:03Z"}, {"machine", "another"}});
  EXPECT_THAT(verdict().sentence, HasSubstr("1 of 3 comparisons disagree"));
}

TEST_F(Page, RefusesWhatIsNoResultFile) {
  const Path target = page();
  const auto refused = [&](const std::string& text, const std::string& says) {
    (void)folder_.write("a.json", text);
    test::expect_run(2, "report " + folder().string() + " --output " + target.string(),
                     AllOf(HasSubstr("a.json"), HasSubstr(says)));
    EXPECT_FALSE(std::filesystem::exists(target)) << "half a page";
  };
  refused("{\"schema\": 1", "is not JSON");
  refused("[]", "must be an object");
  refused(R"({"schema": 2})", "this program reads schema 1");
  refused(std::string(100000, '['), "deep in each other");
  write("a.json", "verify", json::array({1}));
  test::expect_run(2, "report " + folder().string() + " --output " + target.string(),
                   HasSubstr("results[0] must be an object"));
  std::filesystem::create_directory(folder() / "empty");
  test::expect_run(2, "report " + (folder() / "empty").string(), HasSubstr("the folder has no *.json file"));
  test::expect_run(2, "report " + (folder() / "gone").string(), HasSubstr("gone"));
}

TEST_F(Page, PicturesAreInlinedWhereTheyAreThere) {
  const std::string png = "\x89PNG\r\n\x1A\n picture";
  (void)folder_.write("after.png", png);
  (void)folder_.write("x.png", png);
  (void)folder_.write("other.png", png);
  (void)folder_.write("text.png", "a text");
  const json pictures = {
      {"before", "gone.png"}, {"after", "after.png"}, {"grid", "text.png"}, {"x", "x.png"}};
  write("run.json", "run", json::array({{{"scene", "brain"}, {"pictures", pictures}}}));
  make();
  const std::string text = file_text(page());
  EXPECT_THAT(text, AllOf(HasSubstr(R"("0/after.png":"data:image/png;base64,iVBORw0KGgog)"),
                          HasSubstr(R"("0/other.png":)"), HasSubstr(R"("named":["0/after.png"])")));
  EXPECT_THAT(text, AllOf(Not(HasSubstr("0/text.png\":")), Not(HasSubstr("0/gone.png\":")),
                          Not(HasSubstr("0/x.png\":"))));
}

TEST_F(Page, TimingsGoIntoACsvFile) {
  json hardware = bench_row("opencl", 300, 0.5, 2.0);
  hardware["device"] = "a \"GPU\"";
  json wrong = bench_row("gl-compute", 300, 0.1, 9.0);
  wrong["valid"] = false;
  write("bench.json", "bench",
        json::array(
            {bench_row("openmp", 300, 0.25, 4.0), bench_row("openmp", 300, 0.125, 8.0), hardware, wrong}));
  test::expect_run(0, "report " + folder().string() + " --output " + page().string() + " --csv " +
                          (folder() / "t.csv").string());
  EXPECT_EQ(file_text(folder() / "t.csv"),
            "problem,platform,application,fom\n"
            "\"square, 300 x 300, icm\",\"a \"\"GPU\"\" (a machine)\",\"opencl\",0.5\n"
            "\"square, 300 x 300, icm\",\"a machine\",\"gl-compute\",\n"
            "\"square, 300 x 300, icm\",\"a machine\",\"openmp\",0.125\n");
}

} // namespace
} // namespace hdmbench
