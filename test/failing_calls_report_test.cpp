#include "test/report_samples.hpp"

#include <functional>
#include <string>

namespace hdmbench {
namespace {

using namespace report_samples;
using testing::HasSubstr;
using testing::Not;

json failing_calls_row() {
  return json::parse(R"({"backend": "gl-fragment", "api": "OpenGL", "kind": "GL_OUT_OF_MEMORY", "calls": 232,
    "failed": 232, "clean": 213, "succeeded": 19, "went_on": 172, "unclean": []})");
}

class FailingCallsReport : public ReportFolder {
protected:
  std::string page_of(const json& row) { return render(document("failing-calls", rows(row))); }
  std::string error_after(const std::function<void(json&)>& change) {
    json row = failing_calls_row();
    change(row);
    return error_of(document("failing-calls", rows(row)));
  }
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

TEST_F(FailingCallsReport, NoResultsNameTheProgram) {
  EXPECT_THAT(render(document("verify", agreeing_rows())), HasSubstr("test/failing_calls --json FILE"));
}

TEST_F(FailingCallsReport, WhatDoesNotAddUpIsRefused) {
  EXPECT_THAT(error_after([](json& row) { row["clean"] = 212; }), HasSubstr("231 are accounted for"));
  EXPECT_THAT(error_after([](json& row) { row["calls"] = 100; }), HasSubstr("calls"));
  EXPECT_THAT(error_after([](json& row) { row["went_on"] = 214; }), HasSubstr("went_on"));
  EXPECT_THAT(error_after([](json& row) { row.erase("kind"); }), HasSubstr("kind"));
}

} // namespace
} // namespace hdmbench
