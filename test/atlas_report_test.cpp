#include "test/report_samples.hpp"

#include <string>

namespace hdmbench {
namespace {

using namespace report_samples;

json atlas_row() {
  return json::parse(R"({"entry": "offset", "title": "Far <from> 0", "mechanism": "Floats are & coarse.",
    "knob": "offset [px]", "measure": "RMSD [px]", "limit": 0.25, "seen_by": "before the run",
    "energy": "elastic", "survivor": "subtract it", "warnings": ["offset"], "width": 96, "height": 96, "seconds": 1.0,
    "series": [
      {"name": "icm", "absence": "", "last_good": 1000.0, "first_failed": 1e7, "points": [
        {"knob": 0.0, "error": 0.07, "failed": false, "warnings": ["stalled"]},
        {"knob": 1000.0, "error": 0.25, "failed": false, "warnings": []},
        {"knob": 1e7, "error": null, "failed": true, "warnings": ["offset", "stalled"]}]},
      {"name": "multigrid", "absence": "it is not built", "last_good": null, "first_failed": null,
       "points": []}]})");
}

class AtlasReport : public RowsReport {
protected:
  AtlasReport() : RowsReport("atlas", atlas_row()) {}
};

TEST_F(AtlasReport, SaysWhereAndWhyAMethodFails) {
  const std::string page = page_of(atlas_row());
  EXPECT_THAT(page, HasSubstr("Far &lt;from&gt; 0</summary>"));
  EXPECT_THAT(page, HasSubstr("<b>Why.</b> Floats are &amp; coarse."));
  EXPECT_THAT(page, HasSubstr("<b>Energy.</b> elastic"));
  EXPECT_THAT(page, HasSubstr("✗ at 1e+07, ✓ at 1000"));
  EXPECT_THAT(page, HasSubstr("not there: it is not built"));
  EXPECT_THAT(page, HasSubstr("✗ not finite</td><td>offset</td>"));
  EXPECT_THAT(page, HasSubstr("0.07</td><td></td>")); // a warning that is not the entry's
  EXPECT_THAT(page, HasSubstr("aria-label=\"RMSD [px] over offset [px], a line per method\""));
}

TEST_F(AtlasReport, AnEntryWithoutMethodsHasNoPlot) {
  json row = atlas_row();
  row["series"].erase(0);
  EXPECT_THAT(page_of(row), Not(HasSubstr("<svg")));
}

TEST_F(AtlasReport, ContradictionsAreRefused) {
  expect_refused({{"/series/0/points/0/failed", true, "although the limit is 0.25"},
                  {"/series/0/points/2/failed", false, "although the limit is 0.25"},
                  {"/series/1/absence", "", "absence"},
                  {"/energy", "plastic", "must be one of"},
                  {"/mechanism", missing, "mechanism"}});
}

} // namespace
} // namespace hdmbench
