#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdmbench::report {

namespace {

/// A backend on a device: a column.
struct Column {
  std::string backend;
  std::string device;
  std::string driver;
  std::vector<hdmbench::ProbeRow> rows;
};

std::vector<Column> columns_of(const std::vector<ProbeRow>& rows) {
  std::vector<Column> columns;
  for (const ProbeRow& row : rows) {
    auto found = std::ranges::find_if(columns, [&](const Column& column) {
      return column.backend == row.backend && column.device == row.device;
    });
    if (found == columns.end()) {
      found = columns.insert(columns.end(), {row.backend, row.device, row.driver, {}});
    }
    found->rows.push_back(row);
  }
  return columns;
}

std::string css_class(const hdmbench::ProbeRow& row) {
  if (row.answer == ProbeAnswer::as_specified) {
    return "agree";
  }
  return row.agreement_needs_it ? "disagree" : "mistrusted";
}

/// What was asked in which kind of program, in the order in which it first appears.
using Asked = std::pair<bool, std::string>; // whether of the sweep

Asked asked(const hdmbench::ProbeRow& row) {
  return {row.program == "sweep", row.question};
}

std::string table_of(const Results& results, const std::string& machine, const std::vector<ProbeRow>& rows) {
  const std::vector<Column> columns = columns_of(rows);
  std::vector<std::string> names{"Program", "Question"};
  std::vector<Asked> questions;
  for (const Column& column : columns) {
    std::string program;
    for (const hdmbench::ProbeRow& row : column.rows) {
      program = row.program == "sweep" ? program : row.program;
      if (std::ranges::find(questions, asked(row)) == questions.end()) {
        questions.push_back(asked(row));
      }
    }
    names.push_back(fmt::format("{}<small>{}{}</small>", escape(column.backend),
                                device_html(results, machine, column.backend, column.device),
                                program.empty() ? "" : "; " + escape(program)));
  }
  std::string html = table_start("probe", {names.begin(), names.end()});
  for (const Asked& question : questions) {
    html += fmt::format("<tr><td>{}</td><th scope=\"row\">{}</th>", question.first ? "sweep" : "its own",
                        escape(question.second));
    for (const Column& column : columns) {
      const auto row = std::ranges::find(column.rows, question, asked);
      html += row == column.rows.end()
                  ? std::string("<td class=\"skipped\">not asked</td>")
                  : fmt::format("<td class=\"{}\">{}</td>", css_class(*row), escape(answer_text(*row)));
    }
    html += "</tr>\n";
  }
  html += "<tr><td></td><th scope=\"row\">Expected of verify</th>";
  for (const Column& column : columns) {
    html += fmt::format("<td>{}</td>", escape(expected_tier(column.rows)));
  }
  return html + "</tr>\n" + std::string(table_end);
}

} // namespace

std::string probe_section(const Results& results, Anchors& anchors) {
  const std::string introduction =
      "<p>Answers are read from the bits of results, on numbers that tell the cases apart. <b>sweep</b>: in "
      "the "
      "very programs that verify compares. <b>its own</b>: operation by operation, in a small program in the "
      "backend's language. An error of at most 0.5 ulp (unit in the last place) is correctly rounded.</p>\n";
  return section(results, results.probe, anchors,
                 {.anchor = "arithmetic",
                  .title = "Arithmetic of the devices",
                  .without_rows = no_data("answers about arithmetic", "probe"),
                  .introduction = introduction},
                 [&](const std::string& machine, const std::vector<ProbeRow>& rows) {
                   return table_of(results, machine, rows);
                 });
}

} // namespace hdmbench::report
