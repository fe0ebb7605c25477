#include "harness/report/sections.hpp"
#include "harness/scene/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

namespace hdmbench::report {

namespace {

struct Column {
  std::string backend;
  std::string device;
};

/// What was solved: a line of the matrix.
struct Problem {
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string method;

  explicit Problem(const VerifyRow& row)
      : scene(row.scene), width(row.width), height(row.height), method(row.method) {}
  bool operator==(const Problem&) const = default;

  /// "300 x 300, cascade"; icm, which is what scenes say, goes without saying.
  [[nodiscard]] std::string text() const {
    const bool usual = method.empty() || method == "icm";
    return size_text(width, height) + (usual ? "" : ", " + escape(method));
  }
};

// A row that was skipped may have no device; it belongs to its backend's first column.
bool belongs(const VerifyRow& row, const Column& column) {
  return row.backend == column.backend && (row.device.name == column.device || row.device.name.empty());
}

std::vector<Column> columns_of(const std::vector<VerifyRow>& rows) {
  std::vector<Column> columns;
  for (const VerifyRow& row : rows) {
    const auto same = std::ranges::find_if(columns, [&](const Column& column) {
      return row.backend == column.backend &&
             (row.device.name == column.device || row.device.name.empty() || column.device.empty());
    });
    if (same == columns.end()) {
      columns.push_back({row.backend, row.device.name});
    } else if (same->device.empty()) {
      same->device = row.device.name;
    }
  }
  return columns;
}

std::vector<Problem> problems_of(const std::vector<VerifyRow>& rows) {
  std::vector<Problem> problems;
  for (const VerifyRow& row : rows) {
    const Problem problem(row);
    if (std::ranges::find(problems, problem) == problems.end()) {
      problems.push_back(problem);
    }
  }
  return problems;
}

std::string css_class(Verdict verdict) {
  switch (verdict) {
  case Verdict::agree:
    return "agree";
  case Verdict::certified:
    return "certified";
  case Verdict::disagree:
    return "disagree";
  case Verdict::mistrusted:
    return "mistrusted";
  default:
    return "skipped";
  }
}

// With a sign, so that it does not depend on colour.
std::string verdict_html(const VerifyRow& row) {
  switch (row.verdict) {
  case Verdict::agree:
    return fmt::format("✓ {}", name_of(row.tier));
  case Verdict::certified:
    return "≈ certified";
  case Verdict::disagree:
    return "✗ disagrees";
  case Verdict::mistrusted:
    return "? mistrusted";
  default:
    return "– skipped";
  }
}

std::string differing_html(const VerifyRow& row) {
  if (row.verdict == Verdict::skipped || row.verdict == Verdict::mistrusted) {
    return escape(row.reason);
  }
  std::string html =
      plural(row.sites_differing, "site") + (row.sites_differing == 1 ? " differs" : " differ");
  if (row.not_finite > 0) {
    html += fmt::format(", {} not finite", count_text(row.not_finite));
  }
  if (row.counts_differing > 0) {
    html += ", the number of changed sites is wrong after " + plural(row.counts_differing, "iteration");
  }
  return html;
}

std::string line_html(const std::string& modes, const VerifyRow& row) {
  return fmt::format("<div class=\"{}\"><b>{}</b><small>{}: {}</small></div>", css_class(row.verdict),
                     verdict_html(row), modes, differing_html(row));
}

bool say_the_same(const VerifyRow& a, const VerifyRow& b) {
  return a.verdict == b.verdict && a.tier == b.tier && differing_html(a) == differing_html(b);
}

// Modes that say the same in one line.
std::string cell_html(const std::vector<const VerifyRow*>& rows) {
  if (rows.empty()) {
    return "<td class=\"faint\">not compared</td>";
  }
  struct Line {
    const VerifyRow* row;
    std::vector<std::string> modes;
  };
  std::vector<Line> lines;
  for (const VerifyRow* const row : rows) {
    const auto same = std::ranges::find_if(lines, [&](const Line& line) {
      const bool same_mode =
          std::ranges::find(line.modes, std::string(name_of(row->mode))) != line.modes.end();
      return say_the_same(*row, *line.row) && !same_mode;
    });
    if (same == lines.end()) {
      lines.push_back({row, {std::string(name_of(row->mode))}});
    } else {
      same->modes.push_back(std::string(name_of(row->mode)));
    }
  }
  std::string html = "<td>";
  for (const Line& line : lines) {
    html += line_html(joined(line.modes, ", "), *line.row);
  }
  return html + "</td>";
}

std::string matrix_html(const Results& results, const std::string& machine,
                        const std::vector<VerifyRow>& rows) {
  const std::vector<Column> columns = columns_of(rows);
  std::string html = "<div class=\"scroll\"><table class=\"matrix\">\n<thead><tr><th>Scene</th>";
  for (const Column& column : columns) {
    html += fmt::format("<th scope=\"col\">{}<small>{}</small></th>", escape(column.backend),
                        device_html(results, machine, column.backend, column.device));
  }
  html += "</tr></thead>\n<tbody>\n";
  for (const Problem& problem : problems_of(rows)) {
    html +=
        fmt::format("<tr><th scope=\"row\">{}<small>{}</small></th>", escape(problem.scene), problem.text());
    std::vector<bool> placed(rows.size(), false);
    for (const Column& column : columns) {
      std::vector<const VerifyRow*> cell;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (!placed[i] && Problem(rows[i]) == problem && belongs(rows[i], column)) {
          cell.push_back(&rows[i]);
          placed[i] = true;
        }
      }
      html += cell_html(cell);
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

/// What all comparisons of one backend on one device come to.
struct TierLine {
  const Column& column;
  Tier lowest = Tier::exact;
  std::int64_t comparisons = 0; // that were not skipped
  std::int64_t exact = 0;
  std::int64_t sites_compared = 0;
  std::int64_t sites_differing = 0;
  std::int64_t certified = 0;
  std::int64_t uncertified = 0;
  std::int64_t counts_differing = 0;
};

TierLine tier_line(const Column& column, const std::vector<VerifyRow>& rows) {
  TierLine line{.column = column};
  for (const VerifyRow& row : rows) {
    if (row.verdict != Verdict::skipped && belongs(row, column)) {
      line.lowest = std::min(line.lowest, row.tier);
      ++line.comparisons;
      line.exact += row.tier == Tier::exact ? 1 : 0;
      line.sites_compared += row.sites_compared;
      line.sites_differing += row.sites_differing;
      line.certified += row.certified_ties;
      line.uncertified += row.uncertified;
      line.counts_differing += row.counts_differing;
    }
  }
  return line;
}

std::string tier_html(Tier tier) {
  switch (tier) {
  case Tier::none:
    return R"(<td class="disagree"><b>✗ none</b></td>)";
  case Tier::certified:
    return R"(<td class="certified"><b>≈ certified</b></td>)";
  default:
    return fmt::format("<td class=\"agree\"><b>✓ {}</b></td>", name_of(tier));
  }
}

/// One line per backend, over all scenes and modes.
std::string tiers_html(const Results& results, const std::string& machine,
                       const std::vector<VerifyRow>& rows) {
  std::string html =
      table_start("details", {"Backend", "Tier reached", ">Comparisons", ">Of them exact", ">Sites compared",
                              ">Differing", ">Certified", ">Uncertified", ">Wrong counts"});
  for (const Column& column : columns_of(rows)) {
    const TierLine line = tier_line(column, rows);
    html += fmt::format("<tr><th scope=\"row\">{}<small>{}</small></th>", escape(column.backend),
                        device_html(results, machine, column.backend, column.device));
    if (line.comparisons == 0) {
      html += "<td class=\"skipped\">– skipped</td><td class=\"faint\" colspan=\"7\">not run</td></tr>\n";
      continue;
    }
    html += tier_html(line.lowest);
    for (const std::int64_t number : {line.comparisons, line.exact, line.sites_compared, line.sites_differing,
                                      line.certified, line.uncertified, line.counts_differing}) {
      html += fmt::format("<td class=\"number\">{}</td>", count_text(number));
    }
    html += "</tr>\n";
  }
  return html + std::string(table_end);
}

std::string vector_text(const std::array<float, 2>& pixels) {
  const auto text = [](float value) {
    return std::isfinite(value) ? fmt::format("{}", value) : "not finite";
  };
  return fmt::format("({}, {})", text(pixels[0]), text(pixels[1]));
}

std::string first_difference_html(const VerifyRow& row) {
  if (!row.first) {
    return "<td class=\"faint\">none</td>";
  }
  const FirstDifference& first = *row.first;
  std::string more;
  if (std::isfinite(first.expected[0])) {
    more = "expected " + vector_text(first.expected) + ", ";
  }
  if (!more.empty() || std::isfinite(first.found[0])) {
    more += "found " + vector_text(first.found);
  }
  if (std::isfinite(first.energy_before)) {
    more += fmt::format("; energy {:.9g} before, {:.9g} expected, {:.9g} found", first.energy_before,
                        first.energy_expected, first.energy_found);
  }
  return fmt::format("<td class=\"place\">level {}, iteration {}, site ({}, {}){}</td>", first.level,
                     first.iteration, first.x, first.y, more.empty() ? "" : "<small>" + more + "</small>");
}

std::string largest_difference_html(const VerifyRow& row) {
  return std::isfinite(row.largest_difference)
             ? fmt::format("<td class=\"number\">{:.3g}</td>", row.largest_difference)
             : "<td class=\"disagree\">not finite</td>";
}

std::string detail_row_html(const VerifyRow& row, bool with_device) {
  std::string html =
      fmt::format("<tr><th scope=\"row\">{}<small>{}</small></th><td class=\"name\">{}{}</td><td>{}</td>",
                  escape(row.scene), Problem(row).text(), escape(row.backend),
                  with_device ? "<small>" + escape(row.device.name) + "</small>" : "", name_of(row.mode));
  html += fmt::format("<td class=\"{}\">{}{}</td>", css_class(row.verdict), verdict_html(row),
                      row.reason.empty() ? "" : "<small class=\"reason\">" + escape(row.reason) + "</small>");
  if (row.verdict == Verdict::skipped) {
    return html + "<td class=\"faint\" colspan=\"8\">not run</td></tr>\n";
  }
  html += first_difference_html(row);
  for (const std::int64_t number : {std::int64_t{row.levels}, row.iterations, row.sites_compared,
                                    row.sites_differing, row.certified_ties, row.uncertified}) {
    html += fmt::format("<td class=\"number\">{}</td>", count_text(number));
  }
  return html + largest_difference_html(row) + "</tr>\n";
}

std::string details_html(const std::string& title, bool open, const std::vector<VerifyRow>& rows) {
  const std::vector<Column> columns = columns_of(rows);
  std::string html = table_start("details", {"Scene", "Backend", "Mode", "Verdict", "First difference",
                                             ">Levels", ">Iterations", ">Sites compared", ">Differing",
                                             ">Certified", ">Uncertified", ">Largest difference<br>[px]"});
  for (const VerifyRow& row : rows) {
    html += detail_row_html(row, std::ranges::count(columns, row.backend, &Column::backend) > 1);
  }
  return folded(title, html + std::string(table_end), open);
}

std::string all_details_html(const std::vector<VerifyRow>& rows) {
  std::vector<VerifyRow> trouble;
  std::ranges::copy_if(rows, std::back_inserter(trouble), [](const VerifyRow& row) {
    return row.verdict == Verdict::disagree || row.verdict == Verdict::mistrusted;
  });
  std::ranges::stable_sort(trouble, std::greater(), &VerifyRow::verdict); // disagreements first
  std::string html;
  if (!trouble.empty()) {
    html += details_html(plural(std::ssize(trouble), "comparison") + " without agreement", true, trouble);
  }
  return html + details_html("All " + plural(std::ssize(rows), "comparison") + " in figures", false, rows);
}

} // namespace

std::string agreement_section(const Results& results, Anchors& anchors) {
  return section(results, results.verify, anchors,
                 {"agreement", "Agreement with the reference backend", no_data("comparisons", "verify")},
                 [&](const std::string& machine, const std::vector<VerifyRow>& rows) {
                   return tiers_html(results, machine, rows) +
                          folded("Scene by scene", matrix_html(results, machine, rows)) +
                          all_details_html(rows);
                 });
}

} // namespace hdmbench::report
