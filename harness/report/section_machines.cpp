// What was measured where: verdict, machines, support matrix, how to read the page.

#include "harness/measure/choices.hpp"
#include "harness/report/sections.hpp"
#include "harness/report/verdict.hpp"
#include "harness/scene/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace hdmbench::report {

namespace {

std::string state_class(Summary::State state) {
  switch (state) {
  case Summary::State::good:
    return "good";
  case Summary::State::bad:
    return "bad";
  default:
    return "unsure";
  }
}

std::string summary_html(const Summary& summary, const std::string& machine) {
  std::string html = fmt::format("<div class=\"verdict {}\">\n", state_class(summary.state));
  if (!machine.empty()) {
    html += fmt::format("<p class=\"machine\">{}</p>\n", escape(machine));
  }
  html += fmt::format("<p class=\"sentence\">{}</p>\n", escape(summary.sentence));
  for (const std::string& note : summary.notes) {
    html += fmt::format("<p>{}</p>\n", escape(note));
  }
  return html + "</div>\n";
}

std::string definition(std::string_view term, const std::string& value) {
  return fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", term,
                     escape(value.empty() ? "not recorded" : value));
}

// The distinct values that one machine's files give, newest last.
std::string distinct(const std::vector<Source>& sources, const std::string& machine,
                     std::string Source::*member) {
  std::vector<std::string> values;
  for (const Source& source : sources) {
    const std::string& value = source.*member;
    if (source.machine == machine && !value.empty() && std::ranges::find(values, value) == values.end()) {
      values.push_back(value);
    }
  }
  return joined(values, "; ");
}

std::string machine_html(const Results& results, const std::string& machine) {
  const auto& sources = results.sources;
  const auto newest = std::find_if(sources.rbegin(), sources.rend(),
                                   [&](const Source& source) { return source.machine == machine; });
  const auto oldest = std::ranges::find(sources, machine, &Source::machine);
  std::set<std::string> commits;
  for (const Source& source : sources) {
    if (source.machine == machine) {
      commits.insert(source.commit);
    }
  }

  std::string html = "<dl class=\"context\">\n";
  html += definition("Machine", machine);
  if (machine.find(newest->cpu) == std::string::npos) {
    html += definition("Processor", fmt::format("{}, {}", newest->cpu, plural(newest->cores, "core")));
  }
  html += definition("Operating system", distinct(sources, machine, &Source::operating_system));
  html += definition("Compiler", distinct(sources, machine, &Source::compiler));
  html += definition("Compiler flags", distinct(sources, machine, &Source::flags));
  html += definition("Version", distinct(sources, machine, &Source::version));
  html += definition("Commit", distinct(sources, machine, &Source::commit));
  html +=
      definition("Date", oldest->date == newest->date ? newest->date : oldest->date + " to " + newest->date);
  html += "</dl>\n";
  if (commits.size() > 1) {
    html += fmt::format("<p class=\"note\">The results of this machine come from {} different commits.</p>\n",
                        commits.size());
  }
  return html;
}

std::string file_row(const Source& source) {
  std::string fate = fmt::format("{}", plural(static_cast<std::int64_t>(source.rows), "row"));
  if (source.rows == 0) {
    fate = "not shown on this page";
  } else if (source.replaced > 0) {
    fate += fmt::format(", {} of them replaced by newer ones", source.replaced);
  }
  return fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                     escape(source.file.filename().string()), escape(source.machine), escape(source.command),
                     escape(source.date), escape(source.commit), escape(fate));
}

std::string update_mark(const DeviceRow& row, const std::string& update) {
  if (!row.available) {
    return "<td></td>";
  }
  return std::ranges::find(row.updates, update) != row.updates.end() ? "<td class=\"yes\">yes</td>"
                                                                     : "<td class=\"faint\">no</td>";
}

std::string support_row(const Results& results, const std::string& machine, const DeviceRow& row) {
  std::string html = fmt::format("<tr><th scope=\"row\">{}<small>{}</small></th>", escape(row.backend),
                                 escape(row.description));
  if (row.available) {
    html += fmt::format("<td class=\"yes\">yes</td><td>{}</td><td>{}</td>",
                        device_html(results, machine, row.backend, row.device), escape(row.driver));
    html += update_mark(row, "simultaneous") + update_mark(row, "sequential");
  } else {
    html += fmt::format("<td class=\"skipped\">no</td><td class=\"skipped\" colspan=\"4\">{}</td>",
                        escape(row.reason.empty() ? "no reason given" : row.reason));
  }
  return html + "</tr>\n";
}

} // namespace

std::string no_data(std::string_view what, std::string_view command) {
  return fmt::format(
      "<p class=\"empty\">No {} in these results; <code>hdmbench {} --json FILE</code> produces them.</p>\n",
      what, command);
}

std::string machine_heading(const Results& results, const std::string& machine, Anchors& anchors) {
  return results.machines.size() > 1 ? heading(3, anchors.unique("machine " + machine), machine) : "";
}

std::string device_html(const Results& results, const std::string& machine, const std::string& backend,
                        const std::string& device) {
  if (device.empty()) {
    return {};
  }
  return escape(device) +
         (results.is_software(machine, backend, device) ? " <span class=\"tag\">software</span>" : "");
}

std::string summary_section(const Results& results) {
  std::string html = summary_html(summarise(results), "");
  if (const auto golden = summarise_golden(results)) {
    html += summary_html(*golden, "");
  }
  if (const auto accuracy = summarise_accuracy(results)) {
    html += summary_html(*accuracy, "");
  }
  if (results.machines.size() > 1) {
    for (const std::string& machine : results.machines) {
      html += summary_html(summarise(results, machine), machine);
      if (const auto golden = summarise_golden(results, machine)) {
        html += summary_html(*golden, machine);
      }
      if (const auto accuracy = summarise_accuracy(results, machine)) {
        html += summary_html(*accuracy, machine);
      }
    }
  }
  return html;
}

std::string support_section(const Results& results, Anchors& anchors) {
  std::string html = "<section>\n" + heading(2, anchors.unique("support"), "Backends and devices");
  if (results.devices.empty()) {
    html += no_data("devices", "devices");
  }
  for (const std::string& machine : results.machines) {
    html += machine_heading(results, machine, anchors) + machine_html(results, machine);
    const std::vector<DeviceRow> rows = results.of(results.devices, machine);
    if (rows.empty()) {
      continue;
    }
    html += table_start("support", {"Backend", "Available", "Device", "Driver", "Simultaneous updates",
                                    "Sequential updates"});
    for (const DeviceRow& row : rows) {
      html += support_row(results, machine, row);
    }
    html += table_end;
    for (const DeviceRow& row : rows) {
      for (const Choice& choice : row.choices) {
        html += fmt::format("<p><b>{}</b> measures and chooses: {}.</p>\n", escape(row.backend),
                            escape(describe(choice)));
      }
    }
  }
  return html + "</section>\n";
}

std::string reading_section(const Results& results, Anchors& anchors) {
  std::string html = "<section>\n" + heading(2, anchors.unique("reading"), "How to read this page");
  html += R"(<ul class="reading">
<li>Every backend computes the same sweep over the same pyramid; <b>scalar</b>, one plain C++ thread, is what the
others are compared with, at every site after every iteration.</li>
<li><b>resync</b>: every iteration starts from scalar's field, so a difference is that iteration's own.
<b>free</b>: each backend runs on alone; every iteration is judged by what the specification makes of the field that the
backend itself had before it, and how far the fields drift apart is the largest difference.</li>
<li><b>exact</b>: same bits on a scene whose every operation is exact. <b>bitwise</b>: same bits on any scene.
<b>certified</b>: bits differ, but each differing site chose between candidates whose energies lie within the rounding
error bound derived for that site (of a minimiser: it lies within that bound of the exact one). One site that is not
certified is a disagreement, and so is any difference on an exact scene. A backend has reached the lowest tier of its
comparisons.</li>
<li><b>skipped</b> means not run and says nothing about agreement. <b>mistrusted</b> means that the data could not have
revealed a difference, so a match proves nothing.</li>
<li>Times are the median of all samples with the smallest and the largest beneath it, for the whole pyramid. A speed-up
is printed only for a result that was verified; where it was not, the reason stands in its place.</li>
<li>A device tagged <span class="tag">software</span> is the CPU itself or a rasterizer that runs on it: its time says
nothing about a GPU.</li>
<li>Accuracy is measured against three truths: finite elements (FEM) for the <b>model</b>, the fixed point, in which
every site sits at its own minimum, for the <b>optimisation</b>, and the same steps in double for the
<b>arithmetic</b>.</li>
<li>The thesis is C. Seiler, University of Bern, 2008: ATI Radeon X1300 against Core 2 Duo at 1.86 GHz. Its speed-ups
are over its own CPU program.</li>
</ul>
)";
  html += heading(3, anchors.unique("reproduce"), "Reproduce") + "<pre>";
  std::set<std::string> seen;
  for (const Source& source : results.sources) {
    if (seen.insert(source.arguments).second) {
      // The other programs name themselves.
      const std::string_view program = source.command == "instructions"    ? "instruction_count "
                                       : source.command == "failing-calls" ? ""
                                                                           : "hdmbench ";
      html += fmt::format("{}{}\n", program, escape(source.arguments));
    }
  }
  std::string files = table_start("files", {"File", "Machine", "Command", "Date", "Commit", "Rows"});
  for (const Source& source : results.sources) {
    files += file_row(source);
  }
  return html + "</pre>\n" + folded("Result files of this page", files + std::string(table_end)) +
         "</section>\n";
}

} // namespace hdmbench::report
