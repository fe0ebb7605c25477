#include "test/report_samples.hpp"

#include <string>

namespace hdmbench {
namespace {

using namespace report_samples;

json failing_calls_row() {
  return json::parse(R"({"backend": "gl-fragment", "api": "OpenGL", "kind": "GL_OUT_OF_MEMORY", "calls": 232,
    "failed": 232, "clean": 213, "succeeded": 19, "went_on": 172, "unclean": []})");
}

class FailingCallsReport : public RowsReport {
protected:
  FailingCallsReport() : RowsReport("failing-calls", failing_calls_row()) {}
};

TEST_F(FailingCallsReport, SaysThatAllIsClean) {
  const std::string page = page_of(failing_calls_row());
  EXPECT_THAT(page, HasSubstr("232 failing calls: 100 % clean."));
  EXPECT_THAT(page, HasSubstr("<td>GL_OUT_OF_MEMORY</td>"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number agree\">0</td>"));
}

TEST_F(FailingCallsReport, IsReproducedByAProgramOfItsOwn) {
  json where = context();
  where["arguments"] = "failing_calls --quick";
  const std::string page = render(document("failing-calls", rows(failing_calls_row()), where));
  EXPECT_THAT(page, HasSubstr("<pre>failing_calls --quick\n"));
  EXPECT_THAT(page, Not(HasSubstr("hdmbench failing_calls")));
}

TEST_F(FailingCallsReport, SaysWhatIsNotClean) {
  json row = failing_calls_row();
  row["clean"] = 212;
  row["unclean"] = {"7 glBindTexture: <hung>"};
  const std::string page = page_of(row);
  EXPECT_THAT(page, HasSubstr("1 of 232 failing calls were not clean."));
  EXPECT_THAT(page,
              HasSubstr("<li>gl-fragment, OpenGL GL_OUT_OF_MEMORY, call 7 glBindTexture: &lt;hung&gt;</li>"));
  EXPECT_THAT(page, Not(HasSubstr("100 %")));
}

TEST_F(FailingCallsReport, WhatDoesNotAddUpIsRefused) {
  expect_refused({{"/clean", 212, "231 are accounted for"},
                  {"/calls", 100, "calls"},
                  {"/went_on", 214, "went_on"},
                  {"/kind", missing, "kind"}});
}

} // namespace
} // namespace hdmbench
