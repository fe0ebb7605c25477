#include "harness/report/report.hpp"

#include "harness/file_output.hpp"
#include "harness/report/joined.hpp"
#include "harness/report/results.hpp"
#include "harness/report/sections.hpp"
#include "report_assets/page_style.hpp"

#include <fmt/format.h>

#include <string>

namespace hdmbench {

namespace {

std::string page_html(const report::Results& results) {
  const std::string title =
      report::escape(fmt::format("hdmbench on {}", report::joined(results.machines, " and ")));
  // The policy forbids the page to load anything; scripts it has none.
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
      "img-src data:\">\n"
      "<title>{0}</title>\n<style>\n{1}</style>\n</head>\n<body>\n<main>\n<header>\n"
      "<p class=\"overline\">One energy, one sweep, every device</p>\n<h1>{0}</h1>\n",
      title, sources::page_style);
  report::Anchors anchors;
  html += report::summary_section(results);
  html +=
      R"(<nav aria-label="Sections"><a href="#support">What runs where</a><a href="#agreement">Agreement</a>
<a href="#speed">Speed</a><a href="#accuracy">Accuracy</a><a href="#failures">Failures</a> <a href="#pictures">Pictures</a><a href="#reading">How to read</a>
<a href="#reproduce">Reproduce</a></nav>
</header>
)";
  html += report::support_section(results, anchors);
  html += report::agreement_section(results, anchors);
  html += report::speed_section(results, anchors);
  html += report::accuracy_section(results, anchors);
  html += report::atlas_section(results, anchors);
  html += report::pictures_section(results, anchors);
  html += report::reading_section(results, anchors);
  return html + "</main>\n</body>\n</html>\n";
}

} // namespace

void write_report(std::span<const std::filesystem::path> results, const std::filesystem::path& page) {
  require_writable(page);
  write_text(page, page_html(report::load_results(results)));
}

} // namespace hdmbench
