#include "harness/report/sections.hpp"

#include <fmt/format.h>

namespace hdmbench::report {

namespace {

using Rows = std::vector<FailingCallsRow>;

std::int64_t unclean_of(const FailingCallsRow& row) {
  return static_cast<std::int64_t>(row.unclean.size());
}

std::string number_cell(std::int64_t number) {
  return fmt::format("<td class=\"number\">{}</td>", count_text(number));
}

std::string row_html(const FailingCallsRow& row) {
  return fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td>", escape(row.backend),
                     escape(row.api), escape(row.kind)) +
         number_cell(row.calls) + number_cell(row.failed) + number_cell(row.clean) +
         number_cell(row.succeeded) + number_cell(row.went_on) +
         fmt::format("<td class=\"number {}\">{}</td></tr>\n", row.unclean.empty() ? "agree" : "disagree",
                     count_text(unclean_of(row)));
}

/// The sentence, and where it is a bad one what was not clean.
std::string verdict_html(const Rows& rows) {
  std::int64_t failed = 0;
  std::int64_t unclean = 0;
  std::string list;
  for (const FailingCallsRow& row : rows) {
    failed += row.failed;
    unclean += unclean_of(row);
    for (const std::string& what : row.unclean) {
      list += fmt::format("<li>{}, {} {}, call {}</li>\n", escape(row.backend), escape(row.api),
                          escape(row.kind), escape(what));
    }
  }
  if (unclean == 0) {
    return fmt::format("<p class=\"agree\"><b>{} failing calls: 100 % clean.</b></p>\n", count_text(failed));
  }
  return fmt::format(
      "<p class=\"disagree\"><b>{} of {} failing calls were not clean.</b></p>\n<ul>\n{}</ul>\n",
      count_text(unclean), count_text(failed), list);
}

} // namespace

std::string failing_calls_section(const Results& results, Anchors& anchors) {
  const SectionText text{
      "failing calls", "Failing driver calls",
      "<p class=\"empty\">No failing calls among the results. <code>build/release/test/failing_calls --json "
      "FILE</code> writes them.</p>\n",
      "<p>A library between backend and driver makes one call fail per run: the first call in the first "
      "run, the second in the next, and so on. An error is clean if it names the call and the reason, "
      "leaves no object behind, and the next session computes scalar's bits. Calls that only clean up "
      "may fail silently.</p>\n"};
  return section(results, results.failing_calls, anchors, text, [](const std::string&, const Rows& rows) {
    std::string table =
        table_start("failing-calls", {"backend", "API", "what happens", ">calls", ">failed", ">clean error",
                                      ">done without", ">session went on", ">not clean"});
    for (const FailingCallsRow& row : rows) {
      table += row_html(row);
    }
    return verdict_html(rows) + folded("By backend and kind", table + std::string(table_end));
  });
}

} // namespace hdmbench::report
