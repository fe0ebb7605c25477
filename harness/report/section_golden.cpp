#include "harness/report/sections.hpp"
#include "harness/report/verdict.hpp"
#include "harness/scene/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>

namespace hdmbench::report {

namespace {

auto case_of(const GoldenRow& row) {
  return std::tie(row.scene, row.width, row.height, row.method);
}

/// The rows of one case.
using Case = std::vector<const GoldenRow*>;

std::vector<Case> cases_of(const std::vector<GoldenRow>& rows) {
  std::vector<Case> cases;
  for (const GoldenRow& row : rows) {
    const auto same = std::ranges::find_if(
        cases, [&](const Case& known) { return case_of(*known.front()) == case_of(row); });
    if (same == cases.end()) {
      cases.push_back({&row});
    } else {
      same->push_back(&row);
    }
  }
  return cases;
}

/// Backends with a verdict, the reason below each that is not golden.
std::string backends_html(const Case& rows, Verdict verdict, std::string_view sign) {
  std::vector<std::string> names;
  std::string reasons;
  for (const GoldenRow* const row : rows) {
    if (row->verdict == verdict) {
      names.push_back(escape(row->backend));
      if (verdict == Verdict::disagree) {
        reasons += fmt::format("<small>{}: {}</small>", escape(row->backend), escape(row->reason));
      }
    }
  }
  if (names.empty()) {
    return {};
  }
  return fmt::format("<div class=\"{}\"><b>{}</b> {}{}</div>", name_of(verdict), sign, joined(names, ", "),
                     reasons);
}

std::string case_html(const Case& rows) {
  const GoldenRow& first = *rows.front();
  std::string html = fmt::format(
      "<tr><th scope=\"row\">{}<small>{}</small></th><td>{}</td><td><code>{}</code>"
      "{}</td><td>",
      escape(first.scene), size_text(first.width, first.height), escape(first.method), escape(first.hash()),
      first.inputs_reason.empty() ? ""
                                  : fmt::format("<small class=\"disagree\"><b>✗ inputs:</b> {}</small>",
                                                escape(first.inputs_reason)));
  html += backends_html(rows, Verdict::agree, "✓") + backends_html(rows, Verdict::disagree, "✗") +
          backends_html(rows, Verdict::mistrusted, "? as scalar:") +
          backends_html(rows, Verdict::skipped, "– skipped:");
  return html + "</td></tr>\n";
}

std::int64_t count(const std::vector<GoldenRow>& rows, Verdict verdict) {
  return std::ranges::count(rows, verdict, &GoldenRow::verdict);
}

} // namespace

std::optional<Summary> summarise_golden(const Results& results, const std::string& machine) {
  const std::vector<GoldenRow> rows = machine.empty() ? results.golden : results.of(results.golden, machine);
  if (rows.empty()) {
    return std::nullopt;
  }
  const std::int64_t solved = std::ssize(rows) - count(rows, Verdict::skipped);
  Summary summary;
  if (const std::int64_t wrong = count(rows, Verdict::disagree); wrong > 0) {
    summary.state = Summary::State::bad;
    summary.sentence = fmt::format("{} of {} {} not the golden hashes.", count_text(wrong),
                                   plural(solved, "solution"), wrong == 1 ? "has" : "have");
  } else if (const std::int64_t unsure = count(rows, Verdict::mistrusted); unsure > 0) {
    summary.sentence =
        fmt::format("{} of {} {} scalar's bits, but no golden hashes to compare with.", count_text(unsure),
                    plural(solved, "solution"), unsure == 1 ? "has" : "have");
  } else if (solved == 0) {
    summary.sentence = "No golden hash was compared: all solutions were skipped.";
  } else {
    summary.state = Summary::State::good;
    summary.sentence = fmt::format("Every level of {} has the hash that is committed with the program.",
                                   plural(solved, "solution"));
  }
  return summary;
}

std::string golden_section(const Results& results, Anchors& anchors) {
  const SectionText text{
      "golden", "Golden hashes", no_data("golden hashes", "golden"),
      "<p>The field after every level is hashed and compared with the hashes that are committed with the "
      "program. So machines, compilers and versions are compared as well. The table shows the hash of "
      "the full resolution.</p>\n"};
  return section(
      results, results.golden, anchors, text, [](const std::string&, const std::vector<GoldenRow>& rows) {
        std::string table = table_start("golden", {"Scene", "Method", "Hash", "Backends"});
        for (const Case& one : cases_of(rows)) {
          table += case_html(one);
        }
        return folded("All " + plural(std::ssize(rows), "solution"), table + std::string(table_end));
      });
}

} // namespace hdmbench::report
