#include "test/report_samples.hpp"

#include <string>

namespace hdmbench {
namespace {

using namespace report_samples;

json point(const std::string& method, const std::string& effort, double seconds, double error,
           const std::string& scene = "square") {
  json row = json::parse(R"({"kind": "point", "title": "", "width": 300, "height": 300, "poisson": 0.3,
    "rival": false, "usual": true, "backend": "openmp", "device": "CPU", "status": "ok", "valid": true, "reason": "",
    "is_on_front": false, "mean_energy": 1.0, "fine_sweep_equivalents": 2.5})");
  row.update({{"scene", scene},
              {"method", method},
              {"effort", effort},
              {"seconds", {seconds}},
              {"seconds_median", seconds},
              {"rmsd_to_fem_nu0", error},
              {"rmsd_to_fem", 2.0 * error},
              {"rmsd_to_fixed_point", 0.5 * error},
              {"command", "hdmbench run " + scene + " --method " + method}});
  return row;
}

json without_result(json row, const std::string& status, const std::string& reason) {
  row.update({{"status", status}, {"valid", false}, {"reason", reason}, {"seconds", json::array()}});
  for (const char* const key : {"seconds_median", "rmsd_to_fem_nu0", "rmsd_to_fem", "rmsd_to_fixed_point",
                                "mean_energy", "fine_sweep_equivalents"}) {
    row.erase(key);
  }
  return row;
}

json equal_accuracy() {
  return json::parse(
      R"({"kind": "equal accuracy", "scene": "square", "title": "", "width": 300, "height": 300,
    "poisson": 0.3, "target": 0.35, "nearest": 0.2, "iterative": null, "coarse": null,
    "ours": {"method": "cascade", "effort": "4", "backend": "openmp", "seconds_median": 0.02, "rmsd_to_fem_nu0": 0.3},
    "direct": {"method": "fem", "effort": "direct", "backend": "", "seconds_median": 1.0, "rmsd_to_fem_nu0": 0.0,
      "ratio": 50.0, "ratio_low": 40.0, "ratio_high": 60.0}})");
}

json all_rows() {
  json unverified = point("coloured", "50", 0.5, 0.4);
  unverified.update({{"status", "unverified"}, {"valid", false}, {"reason", "7 sites differ from scalar"}});
  json fem = point("fem", "direct", 1.0, 0.0);
  fem.update({{"rival", true}, {"backend", ""}, {"poisson_used", 0.0}});
  fem.erase("fine_sweep_equivalents");
  return rows(point("icm", "5", 0.1, 20.0), point("icm", "50", 0.6, 0.4), point("cascade", "4", 0.02, 0.3),
              unverified, fem, without_result(point("krylov", "4", 1.0, 1.0), "failed", "no <convergence>"),
              without_result(point("sequential", "5", 1.0, 1.0), "skipped", "not here"), equal_accuracy());
}

class TradeoffReport : public RowsReport {
protected:
  TradeoffReport() : RowsReport("tradeoff", point("icm", "5", 0.1, 1.0)) {}
};

TEST_F(TradeoffReport, EveryRowIsAMarkAndARow) {
  const std::string page = page_of(all_rows());
  EXPECT_EQ(occurrences(page, "<g class=\"mark"), 7U);
  EXPECT_EQ(occurrences(page, "<g class=\"mark ok\""), 4U);
  EXPECT_EQ(occurrences(page, "<path class=\"cross\""), 3U);
  EXPECT_THAT(page, HasSubstr("krylov, 4 on openmp: failed\nno &lt;convergence&gt;\nhdmbench run square"));
  EXPECT_THAT(page, HasSubstr("<b>skipped</b>: not here"));
  EXPECT_THAT(page, HasSubstr("All 7 points of square"));
  EXPECT_EQ(occurrences(page, "class=\"series\""), 1U) << "icm alone has two efforts";
}

TEST_F(TradeoffReport, TheFrontIsOfWhatIsOkAndUndominated) {
  const std::string page = page_of(all_rows());
  const std::size_t start = page.find("data-view=\"0 0\"");
  const std::string front = page.substr(start, page.find("</g>", start) - start);
  EXPECT_THAT(front, HasSubstr(">cascade<"));
  EXPECT_THAT(front, HasSubstr(">fem, ν = 0<"));
  EXPECT_THAT(front, Not(HasSubstr("icm")));
  json results = all_rows();
  results[3].update({{"seconds", {0.001}}, {"seconds_median", 0.001}, {"rmsd_to_fem_nu0", 0.001}});
  const std::string other = page_of(results);
  const std::size_t again = other.find("data-view=\"0 0\"");
  EXPECT_THAT(other.substr(again, other.find("</g>", again) - again), Not(HasSubstr("coloured")));
}

TEST_F(TradeoffReport, WorksWithoutTheScript) {
  const std::string page = page_of(all_rows());
  EXPECT_EQ(occurrences(page, "data-view=\"0 0\"><path"), 1U) << "the first view is shown";
  EXPECT_EQ(occurrences(page, "data-view=\"0 1\" display=\"none\""), 1U);
  EXPECT_THAT(page, HasSubstr("<form class=\"switches\" hidden>"));
  EXPECT_THAT(page, Not(HasSubstr("aria-pressed=\"false\">"))) << "buttons that do nothing are disabled";
  EXPECT_THAT(page, HasSubstr("; script-src 'sha256-"));
  EXPECT_EQ(occurrences(page, "<script>"), 1U);
  EXPECT_EQ(occurrences(render(document("verify", agreeing_rows())), "<script"), 0U);
}

TEST_F(TradeoffReport, AllScenesAddUpSecondsAndKeepTheWorst) {
  json results = all_rows();
  results.push_back(point("cascade", "4", 0.03, 0.9, "brain"));
  const std::string page = page_of(results);
  EXPECT_THAT(page, HasSubstr("<h4>All scenes of "));
  EXPECT_THAT(page, HasSubstr("cascade, 4 on openmp\n0.0500 s, 5 fine-sweep equivalents; RMSD 0.9 px"));
  EXPECT_THAT(page, HasSubstr("icm, 5 on openmp: skipped\nnot measured on brain"));
}

TEST_F(TradeoffReport, EqualAccuracyIsATable) {
  const std::string page = page_of(all_rows());
  EXPECT_THAT(page, HasSubstr("<b>50.0×</b><small>40 to 60; direct, 1.00 s</small>"));
  EXPECT_THAT(page, HasSubstr("nowhere that near"));
  json results = all_rows();
  results.back()["ours"] = nullptr;
  EXPECT_THAT(page_of(results), HasSubstr("No method is that near; the nearest is 0.2 px away."));
}

TEST_F(TradeoffReport, RefusesRowsThatContradictThemselves) {
  expect_refused({{"/seconds_median", 100.0, "seconds_median"},
                  {"/seconds", json::array(), "seconds"},
                  {"/rmsd_to_fem", nullptr, "\"ok\" although"},
                  {"/rmsd_to_fem", -1.0, "negative"},
                  {"/status", "fine", "must be one of"},
                  {"/status", "failed", "must say why"},
                  {"/kind", "line", "kind"}});
}

} // namespace
} // namespace hdmbench
