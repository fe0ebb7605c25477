#include "harness/report/report.hpp"

#include "harness/report/portability.hpp"
#include "harness/report/results.hpp"
#include "harness/report/sections.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/joined.hpp"
#include "report_assets/page_style.hpp"
#include "report_assets/tradeoff_script.hpp"

#include <fmt/format.h>

namespace hdmbench {

namespace {

/// Of tradeoff.js, as a Content-Security-Policy has it: base64 of the bytes that CMake gives in hexadecimal.
std::string script_digest() {
  const std::string_view digits = HDMBENCH_TRADEOFF_SCRIPT_SHA256;
  std::string bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(std::string(digits.substr(i, 2)), nullptr, 16));
  }
  return report::base64(bytes);
}

std::string page_html(const report::Results& results) {
  const std::string title = report::escape(fmt::format("hdmbench on {}", joined(results.machines, " and ")));
  // The policy forbids the page to load anything, and to run anything but our script: no text that a result
  // file smuggles in can.
  const std::string script_policy =
      results.tradeoff.empty() ? "" : fmt::format("; script-src 'sha256-{}'", script_digest());
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
      "img-src data:{2}\">\n"
      "<title>{0}</title>\n<style>\n{1}</style>\n</head>\n<body>\n<main>\n<header>\n"
      "<p class=\"overline\">Image deformation by energy minimisation on CPUs and GPUs: same bits, speed, "
      "accuracy</p>\n<h1>{0}</h1>\n",
      title, sources::page_style, script_policy);
  report::Anchors anchors;
  html += report::summary_section(results);
  html +=
      R"(<nav aria-label="Sections"><a href="#tradeoff">Speed and accuracy</a>
<a href="#pictures">Displacement fields</a>
<a href="#registration">Registration</a>
<a href="#speed">Speed</a>
<a href="#ranks">Several ranks</a>
<a href="#portability">Machines side by side</a>
<a href="#agreement">Agreement</a>
<a href="#implementations">What runs where</a>
<a href="#arithmetic">Arithmetic of the devices</a>
<a href="#accuracy">Accuracy</a>
<a href="#continuum">Pixels and continuum</a>
<a href="#failures">Failure atlas</a>
<a href="#golden">Golden hashes</a>
<a href="#faults">Planted faults</a>
<a href="#failing-calls">Failing driver calls</a>
<a href="#before-and-after">Before and after</a>
<a href="#instructions">Instruction counts</a>
<a href="#support">Backends and devices</a>
<a href="#reading">How to read</a>
<a href="#reproduce">Reproduce</a></nav>
</header>
)";
  html += report::tradeoff_section(results, anchors);
  html += report::pictures_section(results, anchors);
  html += report::registration_section(results, anchors);
  html += report::speed_section(results, anchors);
  html += report::scaling_section(results, anchors);
  html += report::portability_section(results, anchors);
  html += report::agreement_section(results, anchors);
  html += report::implementations_section(results, anchors);
  html += report::probe_section(results, anchors);
  html += report::accuracy_section(results, anchors);
  html += report::continuum_section(results, anchors);
  html += report::atlas_section(results, anchors);
  html += report::golden_section(results, anchors);
  html += report::faults_section(results, anchors);
  html += report::failing_calls_section(results, anchors);
  html += report::compare_section(results, anchors);
  html += report::instructions_section(results, anchors);
  html += report::support_section(results, anchors);
  html += report::reading_section(results, anchors);
  const std::string script =
      results.tradeoff.empty() ? "" : fmt::format("<script>{}</script>\n", sources::tradeoff_script);
  return html + "</main>\n" + script + "</body>\n</html>\n";
}

} // namespace

void write_report(std::span<const std::filesystem::path> results, const std::filesystem::path& page) {
  require_writable(page);
  write_text(page, page_html(report::load_results(results)));
}

void write_p3_csv(std::span<const std::filesystem::path> results, const std::filesystem::path& file) {
  write_text(file, report::p3_csv(report::portability(report::load_results(results))));
}

} // namespace hdmbench
