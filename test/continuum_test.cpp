// What `continuum` measures, and how its page shows it.

#include "backends/registry.hpp"
#include "harness/judge/continuum/continuum.hpp"
#include "harness/scene/row_fields.hpp"
#include "test/report_samples.hpp"

#include <array>
#include <string>

namespace hdmbench {
namespace {

using namespace report_samples;

std::vector<ContinuumRow> measured(double contrast) {
  constexpr std::array sides{33, 65, 129};
  Progress silent(false);
  const auto registry = make_backends();
  return measure_continuum(contrast, sides, find_backend(registry, "openmp"), {}, silent);
}

/// Stretched evenly: bilinear elements have that displacement (the patch test), and so must our field.
TEST(Continuum, OneMaterialHasNoErrorButThatOfFloat) {
  for (const ContinuumRow& row : measured(1.0)) {
    EXPECT_LT(row.discretisation.largest, 2e-5) << "the border is given in float32: 25 px to 24 bits";
    EXPECT_LT(row.rounding.largest, 2e-5);
  }
}

TEST(Continuum, ErrorsAreApart) {
  for (const double contrast : {0.1, 10.0}) {
    const std::vector<ContinuumRow> rows = measured(contrast);
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_EQ(rows.front().order, std::nullopt);
    EXPECT_GT(rows.back().order.value(), 0.8) << contrast;
    for (const ContinuumRow& row : rows) {
      EXPECT_GT(row.discretisation.rmsd, 100.0 * row.rounding.rmsd) << row.width;
      EXPECT_LT(row.algebraic.rmsd, row.discretisation.rmsd) << row.width;
      EXPECT_LT(row.rounding.largest, 2e-5) << row.width;
      EXPECT_GT(row.rounding.rmsd, 0.0) << row.width;
    }
  }
}

json continuum_row() {
  return json::parse(R"({"energy": "elastic", "width": 50, "height": 50, "contrast": 10.0, "poisson": 0.3,
    "stretch": 50.0, "backend": "openmp", "device": "2 threads", "method": "full-multigrid",
    "discretisation": {"rmsd": 0.125, "largest": 0.5}, "algebraic": {"rmsd": 0.03125, "largest": 0.25},
    "rounding": {"rmsd": 1.25e-6, "largest": 5e-6}, "total": {"rmsd": 0.15, "largest": 0.75}, "order": 1.25})");
}

class ContinuumReport : public RowsReport {
protected:
  ContinuumReport() : RowsReport("continuum", continuum_row()) {}
};

TEST_F(ContinuumReport, ShowsTheErrorsApart) {
  const std::string page = page_of(continuum_row());
  EXPECT_THAT(page,
              HasSubstr("<td class=\"number\">0.12<small>0.5</small></td><td class=\"number\">1.25</td>"));
  EXPECT_THAT(page, HasSubstr("0.031<small>0.25</small>"));
  EXPECT_THAT(page, HasSubstr("1.3e-06<small>5e-06</small>"));
  EXPECT_THAT(page, HasSubstr("0.15<small>0.75</small>"));
}

TEST_F(ContinuumReport, ShowsTheFinestMeshAndFoldsTheOthers) {
  json larger = continuum_row();
  larger.update({{"width", 300}, {"height", 300}});
  const std::string page = page_of(rows(larger, continuum_row()));
  const std::size_t fold = page.find("<summary>All sizes</summary>");
  ASSERT_NE(fold, std::string::npos);
  EXPECT_EQ(occurrences(page, "300\u00A0×\u00A0300"), 2U);
  EXPECT_LT(page.find("300\u00A0×\u00A0300"), fold);
  EXPECT_GT(page.find("50\u00A0×\u00A050"), fold);
}

TEST_F(ContinuumReport, ContradictionsAreRefused) {
  expect_refused({{"/total/rmsd", 0.16, "more than discretisation and algebraic error together"},
                  {"/algebraic/largest", 0.03, "above the largest distance"},
                  {"/rounding/rmsd", -1e-6, "must not be negative"},
                  {"/energy", "plastic", "must be one of"},
                  {"/order", missing, "order"}});
}

} // namespace
} // namespace hdmbench
