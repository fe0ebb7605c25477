#include "test/report_samples.hpp"

#include <string>

namespace hdmbench {
namespace {

using namespace report_samples;

json instructions_row(const std::string& group, const std::string& shader, int candidates, int energies,
                      json instructions) {
  json row = json::parse(R"({"texture_instructions": 11, "temporaries": 17, "flow_control": 0, "refusal": "",
    "scalar_operations": 232, "device": "ATI <RV515>", "driver": "OpenGL 2.1", "instructions_limit": 512,
    "temporaries_limit": 128})");
  if (instructions.is_null()) {
    row.update(
        json::parse(R"({"texture_instructions": null, "temporaries": null, "refusal": "Too <many>"})"));
  }
  row.update({{"group", group}, {"shader", shader}, {"candidates", candidates}, {"energies", energies}});
  row["instructions"] = std::move(instructions);
  return row;
}

class InstructionsReport : public RowsReport {
protected:
  InstructionsReport() : RowsReport("instructions", instructions_row("methods", "icm", 5, 0, 128)) {}
};

TEST_F(InstructionsReport, SaysWhatFits) {
  const std::string page = page_of(rows(instructions_row("candidates", "", 5, 0, 128),
                                        instructions_row("candidates", "", 6, 0, 140),
                                        instructions_row("candidates", "", 7, 0, nullptr)));
  EXPECT_THAT(page,
              HasSubstr("2 of the 3 sets fit; the largest of them has 6 candidates and takes 140 of 512"));
  EXPECT_THAT(page, HasSubstr("<b>no</b>: Too &lt;many&gt;"));
  EXPECT_THAT(page, HasSubstr("Compiled for ATI &lt;RV515&gt;"));
}

TEST_F(InstructionsReport, WeighsTheThesissClaim) {
  const auto row = [](const char* shader, int candidates, json instructions) {
    return instructions_row("vectors", shader, candidates, candidates * candidates, std::move(instructions));
  };
  EXPECT_THAT(page_of(rows(row("a", 4, 496), row("a", 6, nullptr))), HasSubstr(">4 fit, 6 do not<"));
  EXPECT_THAT(page_of(rows(row("a", 4, 253), row("a", 6, 434))), HasSubstr("both fit"));
  EXPECT_THAT(page_of(rows(row("a", 4, nullptr), row("a", 6, nullptr))), HasSubstr("neither fits"));
  EXPECT_THAT(page_of(rows(row("a", 4, 496), row("b", 6, nullptr))), Not(HasSubstr(">4 fit, 6 do not<")));
}

TEST_F(InstructionsReport, TheNewestFileReplacesTheOlder) {
  const auto older =
      write("older.json", document("instructions", rows(instructions_row("methods", "gone", 5, 0, 128)),
                                   context("bench-1", "2026-11-20T00:00:00Z")));
  const auto newer =
      write("newer.json", document("instructions", rows(instructions_row("methods", "icm", 5, 0, 128))));
  const std::string page = render_files({newer, older});
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">icm</th>"));
  EXPECT_THAT(page, Not(HasSubstr("<th scope=\"row\">gone</th>")));
}

TEST_F(InstructionsReport, ContradictionsAreRefused) {
  expect_refused({{"/instructions", 513, "although the limit is 512"},
                  {"/instructions", nullptr, "refusal"},
                  {"/refusal", "no", "refusal"},
                  {"/group", "others", "group"},
                  {"/device", missing, "device"}});
}

} // namespace
} // namespace hdmbench
