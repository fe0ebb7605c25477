#include "test/report_samples.hpp"

#include <string>

namespace hdmbench {
namespace {

using namespace report_samples;

json scaling_row(int ranks, json seconds, double modelled, int size = 1024) {
  return {{"scene", "<square>"},
          {"scaling", "strong"},
          {"backend", "openmp"},
          {"ranks", ranks},
          {"width", size},
          {"height", size},
          {"seconds", std::move(seconds)},
          {"modelled_seconds", modelled},
          {"messages", 12345},
          {"bytes", 2500000}};
}

class ScalingReport : public RowsReport {
protected:
  ScalingReport() : RowsReport("scaling", scaling_row(1, {0.5, 0.4, 0.6}, 0.45)) {}
};

TEST_F(ScalingReport, SaysHowFarTheModelIsOff) {
  const std::string page =
      page_of(rows(scaling_row(1, {0.5, 0.4, 0.6}, 0.45), scaling_row(2, {0.2, 0.2, 0.3}, 0.25)));
  EXPECT_THAT(page, AllOf(HasSubstr("+12 %"), HasSubstr("+25 %"), HasSubstr("&lt;square&gt;"),
                          HasSubstr("2.50"), Not(HasSubstr("id=\"ranks-model\""))));
}

TEST_F(ScalingReport, DrawsTheModelAndSaysWhereItEnds) {
  const json none = json::array();
  const auto page = [&](double last) {
    return page_of(rows(scaling_row(1, {0.5}, 0.5), scaling_row(4, none, 30.0, 65536),
                        scaling_row(1, none, 100.0, 65536), scaling_row(2, none, 55.0, 65536),
                        scaling_row(8, none, last, 65536)));
  };
  EXPECT_THAT(page(28.0), AllOf(HasSubstr("id=\"ranks-model\""), HasSubstr("on up to 8 ranks"),
                                HasSubstr("Beyond 4 ranks twice as many save less than a tenth")));
  EXPECT_THAT(page(16.0), HasSubstr("save more than a tenth all the way"));
}

TEST_F(ScalingReport, WithoutRowsItNamesTheCommand) {
  EXPECT_THAT(page_of(json::array()), HasSubstr("bench --scaling strong"));
}

TEST_F(ScalingReport, NonsenseIsRefused) {
  expect_refused({{"/scaling", "weakly", "scaling"},
                  {"/seconds", "fast", "seconds"},
                  {"/ranks", -1, "ranks"},
                  {"/modelled_seconds", missing, "modelled_seconds"}});
}

} // namespace
} // namespace hdmbench
