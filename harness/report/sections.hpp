#pragma once

#include "harness/report/html.hpp"
#include "harness/report/results.hpp"

#include <string>

/// The parts of the page, in its order, each a run of HTML. A part without data says which command produces
/// it.
namespace hdmbench::report {

[[nodiscard]] std::string summary_section(const Results& results); ///< verdict and machines
[[nodiscard]] std::string support_section(const Results& results, Anchors& anchors);
[[nodiscard]] std::string agreement_section(const Results& results, Anchors& anchors);
/// Agreement on other drivers than the installed ones.
[[nodiscard]] std::string implementations_section(const Results& results, Anchors& anchors);
/// What each device's arithmetic does.
[[nodiscard]] std::string probe_section(const Results& results, Anchors& anchors);
/// What mistakes the cross-check has been seen to find.
[[nodiscard]] std::string faults_section(const Results& results, Anchors& anchors);
[[nodiscard]] std::string golden_section(const Results& results, Anchors& anchors);
/// Tables and plots; needs gnuplot where there are valid timings.
[[nodiscard]] std::string speed_section(const Results& results, Anchors& anchors);
/// Several ranks, measured and modelled; needs gnuplot where there are results.
[[nodiscard]] std::string scaling_section(const Results& results, Anchors& anchors);
/// Machines side by side, and the performance portability of each backend.
[[nodiscard]] std::string portability_section(const Results& results, Anchors& anchors);
/// Timings before and after a change; needs gnuplot where there are any.
[[nodiscard]] std::string compare_section(const Results& results, Anchors& anchors);
/// Tables and figures against the truths; needs gnuplot where there are profiles or convergence.
[[nodiscard]] std::string accuracy_section(const Results& results, Anchors& anchors);
/// How far finite elements on pixels are from the continuum.
[[nodiscard]] std::string continuum_section(const Results& results, Anchors& anchors);
/// Where the methods fail; needs gnuplot where there are results.
[[nodiscard]] std::string atlas_section(const Results& results, Anchors& anchors);
/// The thesis's limit of 512 operations.
[[nodiscard]] std::string instructions_section(const Results& results, Anchors& anchors);
/// Whether every error of a driver is told.
[[nodiscard]] std::string failing_calls_section(const Results& results, Anchors& anchors);
/// Interactive charts; the page needs tradeoff.js where there are results.
[[nodiscard]] std::string tradeoff_section(const Results& results, Anchors& anchors);
[[nodiscard]] std::string pictures_section(const Results& results, Anchors& anchors);
/// register, detect, and both against planted truth.
[[nodiscard]] std::string registration_section(const Results& results, Anchors& anchors);
[[nodiscard]] std::string reading_section(const Results& results, Anchors& anchors);

/// "<p>" saying that `command` makes what would stand here.
[[nodiscard]] std::string no_data(std::string_view what, std::string_view command);

/// A <h3> with the machine's name where the page has several machines, else nothing.
[[nodiscard]] std::string machine_heading(const Results& results, const std::string& machine,
                                          Anchors& anchors);

/// The device as a table shows it: escaped, with a tag where it is the CPU in disguise.
[[nodiscard]] std::string device_html(const Results& results, const std::string& machine,
                                      const std::string& backend, const std::string& device);

/// A sentence where any of the rows comes from a --quick run, else nothing.
template <typename Row>
[[nodiscard]] std::string quick_note(const Results& results, const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    if (results.sources[row.source].quick) {
      return R"(<p class="note">Includes results of <code>--quick</code>, good enough to see that everything works, not to
quote: fewer iterations compared, fewer sizes timed than in a full run.</p>
)";
    }
  }
  return {};
}

/// What a part of the page says before its rows and, without any, in their place: HTML, but for the title.
struct SectionText {
  std::string_view anchor;
  std::string_view title;
  std::string without_rows;
  std::string_view introduction{};
};

/// A part of the page from the rows of a command: for each machine that has some, `content(machine, rows)`.
template <typename Row, typename Content>
[[nodiscard]] std::string section(const Results& results, const std::vector<Row>& rows, Anchors& anchors,
                                  const SectionText& text, const Content& content) {
  std::string html = "<section>\n" + heading(2, anchors.unique(text.anchor), text.title);
  html += rows.empty() ? text.without_rows : std::string(text.introduction) + quick_note(results, rows);
  for (const std::string& machine : results.machines) {
    const std::vector<Row> of_machine = results.of(rows, machine);
    if (!of_machine.empty()) {
      html += machine_heading(results, machine, anchors) + content(machine, of_machine);
    }
  }
  return html + "</section>\n";
}

} // namespace hdmbench::report
