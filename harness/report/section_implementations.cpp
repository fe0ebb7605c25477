#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace hdmbench::report {

namespace {

std::string css_class(Outcome outcome) {
  return outcome == Outcome::passed ? "agree" : outcome == Outcome::absent ? "skipped" : "disagree";
}

std::string row_html(const ImplementationRow& row) {
  const bool ran = row.outcome != Outcome::absent;
  const std::string_view verdict = row.outcome == Outcome::passed ? name_of(row.tier) : name_of(row.outcome);
  std::string html = fmt::format(
      "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}<small>{}</small></td><td class=\"{}\">{}</td>",
      escape(row.backend), escape(row.implementation), escape(row.device), escape(row.driver),
      css_class(row.outcome), verdict);
  if (ran && row.reason.empty()) {
    for (const std::int64_t count : {row.scenes, row.comparisons, row.sites_compared}) {
      html += fmt::format("<td class=\"number\">{}</td>", count_text(count));
    }
    html += fmt::format("<td class=\"number\">{} s</td><td class=\"number\">{:.0f} MB</td>",
                        seconds_text(row.seconds), static_cast<double>(row.peak_bytes) / 1e6);
  } else {
    html += fmt::format("<td colspan=\"5\">{}</td>", escape(row.reason));
  }
  return html + "</tr>\n";
}

/// The page of `hdmbench browser`, where it stands beside the results.
std::string browser_link(const Results& results) {
  const bool there = std::ranges::any_of(results.sources, [](const Source& source) {
    return std::filesystem::exists(source.file.parent_path() / "browser.html");
  });
  return there ? "<p><a href=\"browser.html\">The same comparison on the GPU of your browser</a>, without a "
                 "network.</p>\n"
               : "";
}

} // namespace

std::string implementations_section(const Results& results, Anchors& anchors) {
  const std::string introduction = browser_link(results) +
                                   "<p>The same comparison with scalar on every implementation of OpenGL and "
                                   "Vulkan that the machine has, each in "
                                   "a process of its own: one that hangs or crashes is a line here.</p>\n";
  const std::string without_rows =
      browser_link(results) + no_data("comparisons on other implementations", "implementations");
  return section(results, results.implementations, anchors,
                 {.anchor = "implementations",
                  .title = "What runs where",

                  .without_rows = without_rows,
                  .introduction = introduction},
                 [](const std::string&, const std::vector<ImplementationRow>& rows) {
                   std::string table = table_start(
                       "implementations", {"Backend", "Implementation", "Device", "Verdict", ">Scenes",
                                           ">Comparisons", ">Sites compared", ">Time", ">Memory"});
                   for (const ImplementationRow& row : rows) {
                     table += row_html(row);
                   }
                   return table + std::string(table_end);
                 });
}

} // namespace hdmbench::report
