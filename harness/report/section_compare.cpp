#include "harness/measure/median.hpp"
#include "harness/report/gnuplot.hpp"
#include "harness/report/plot_style.hpp"
#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace hdmbench::report {

namespace {

using comparison::Change;
using Rows = std::vector<ComparedRow>;

/// A verdict, its colour on the page and that of its mark in the figure.
struct Look {
  std::string_view css_class;
  std::string_view colour;
};

Look look_of(const ComparedRow& row) {
  switch (row.comparison.change) {
  case Change::faster:
    return {"agree", "00795a"};
  case Change::slower:
    return row.comparison.slower_than_tolerated ? Look{"disagree", "9f1d2f"} : Look{"mistrusted", "b04a00"};
  case Change::none_seen:
    return {"", "1f2328"};
  default:
    return {"mistrusted", "8a8f98"};
  }
}

std::string backend_text(const ComparedRow& row) {
  return row.row.backend + (row.row.threads ? ", " + plural(*row.row.threads, "thread") : "");
}

std::string verdict_text(const ComparedRow& row) {
  const Change change = row.comparison.change;
  const bool borne = change == Change::slower && !row.comparison.slower_than_tolerated;
  return fmt::format("{}{}", names_of(change).at(static_cast<std::size_t>(change)),
                     borne ? ", within the tolerance" : "");
}

std::string row_html(const ComparedRow& row) {
  std::string html = fmt::format("<tr><th scope=\"row\">{}<small>{}</small></th><td>{}<small>{}</small></td>",
                                 escape(row.row.scene), size_text(row.row.width, row.row.height),
                                 escape(backend_text(row)), escape(row.row.method));
  const std::string remark = row.remark.empty() ? "" : fmt::format("<small>{}</small>", escape(row.remark));
  if (!row.compared) {
    return html + fmt::format("<td colspan=\"6\" class=\"skipped\">not compared{}</td></tr>\n", remark);
  }
  html += fmt::format(
      "<td class=\"number\">{} + {}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>",
      row.first.size(), row.second.size(), seconds_text(median(row.first)), seconds_text(median(row.second)));
  const comparison::Ratio& ratio = row.comparison.ratio;
  return html + fmt::format("<td class=\"number\">{:.3f}<small>{:.3f} … {:.3f} ({:.0f} %)</small></td>"
                            "<td class=\"number\">{:.2g}</td><td class=\"{}\"><b>{}</b>{}</td></tr>\n",
                            ratio.estimate, ratio.low, ratio.high, 100.0 * ratio.coverage, row.comparison.p,
                            look_of(row).css_class, escape(verdict_text(row)), remark);
}

/// One line per timing, from the top: the interval, its estimate, and 1 to compare with.
std::string ratio_plot(const Rows& rows, const std::string& prefix, const std::string& label) {
  constexpr double width = 760.0;
  constexpr double line_height = 20.0;
  constexpr Margins margins{330.0, 20.0, 12.0, 48.0};
  const double height = margins.top + margins.bottom + line_height * static_cast<double>(rows.size() + 1);
  std::string tics;
  std::string blocks;
  std::string command = "plot ";
  double farthest = 1.05;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ComparedRow& row = rows[i];
    const comparison::Ratio& ratio = row.comparison.ratio;
    const std::size_t position = rows.size() - i;
    const std::string name = fmt::format("{} {}×{}, {}, {}", row.row.scene, row.row.width, row.row.height,
                                         backend_text(row), row.row.method);
    tics += fmt::format("{}{} {}", i == 0 ? "" : ", ", gnuplot_text(name), position);
    blocks += fmt::format("$row{} << END\n{:.6g} {} {:.6g} {:.6g}\nEND\n", i, ratio.estimate, position,
                          ratio.low, ratio.high);
    command += fmt::format("{}$row{} using 1:2:3:4 with xerrorbars pt 7 ps 0.6 lw 1.5 lc rgb \"#{}\" notitle",
                           i == 0 ? "" : ", ", i, look_of(row).colour);
    farthest = std::max({farthest, ratio.high, 1.0 / ratio.low});
  }
  const double end = std::pow(farthest, 1.1);
  return gnuplot_svg(
      plot_start(width, height) + plot_margins(width, height, margins) +
          x_title("new / old: left is faster", height) +
          fmt::format(
              "set logscale x 2\nset format x \"%.3g\"\nset xrange [{:.6g}:{:.6g}]\nset yrange [0:{}]\n"
              "set ytics noenhanced ({})\n"
              "set arrow from 1, graph 0 to 1, graph 1 nohead lw 1.2 lc rgb \"#6e6e6e\"\n",
              1.0 / end, end, rows.size() + 1, tics) +
          (end < 2.0 ? fmt::format("set xtics ({:.3g}, 1, {:.3g})\n", 1.0 / farthest, farthest) : "") +
          blocks + command + '\n',
      prefix, label);
}

/// What was compared with what, and what came out.
std::string summary_html(const Rows& rows, const Rows& compared) {
  const ComparedRow& any = rows.front();
  std::string html = "<p>";
  if (!any.old_commit.empty() && !any.new_commit.empty()) {
    html += fmt::format("Old is commit <code>{}</code>, new is <code>{}</code>. ", escape(any.old_commit),
                        escape(any.new_commit));
  }
  html += std::ranges::all_of(rows, &ComparedRow::interleaved)
              ? "Measured in turn, a process a sample, so that a drift of the machine hits both.</p>\n"
              : "Measured at different times: a drift of the machine looks like a difference.</p>\n";
  const auto regressions = std::ranges::count_if(
      compared, [](const ComparedRow& row) { return row.comparison.slower_than_tolerated; });
  const auto noisy =
      std::ranges::count_if(compared, [](const ComparedRow& row) { return row.comparison.noisy(); });
  std::string totals;
  for (std::size_t i = 0; i < comparison::change_names.size(); ++i) {
    const auto count = std::ranges::count_if(
        compared, [&](const ComparedRow& row) { return row.comparison.change == static_cast<Change>(i); });
    if (count > 0) {
      totals += fmt::format("{}{} {}", totals.empty() ? "" : ", ", count, comparison::change_names.at(i));
    }
  }
  html += fmt::format("<p class=\"{}\"><b>Of {}: {}.</b>{}</p>\n", regressions > 0 ? "disagree" : "agree",
                      plural(std::ssize(compared), "timing"), totals.empty() ? "none compared" : totals,
                      regressions > 0 ? fmt::format(" {} by more than is tolerated.", regressions) : "");
  if (noisy > 0) {
    html += fmt::format(
        "<p class=\"note\">{} of them {} noisier than the tolerance bears: a change of its size is "
        "easily overlooked there.</p>\n",
        noisy, noisy == 1 ? "is" : "are");
  }
  return html;
}

std::string machine_html(const Rows& rows, const std::string& machine, Anchors& anchors) {
  Rows compared;
  std::ranges::copy_if(rows, std::back_inserter(compared), &ComparedRow::compared);
  std::string html = summary_html(rows, compared);
  if (!compared.empty()) {
    const std::string id = anchors.unique("ratios");
    html += fmt::format(
        "<figure class=\"plot\" id=\"{}\">{}<figcaption>Ratio of times with its interval. An interval that "
        "holds 1 is no proof of anything.</figcaption></figure>\n",
        id, ratio_plot(compared, id + '_', "Ratios of times, new over old, on " + machine));
  }
  html += table_start(
      "compare", {"Scene", "Backend, method", ">Samples", ">Old s", ">New s", ">New / old", ">p", "Verdict"});
  for (const ComparedRow& row : rows) {
    html += row_html(row);
  }
  return html + std::string(table_end);
}

} // namespace

std::string compare_section(const Results& results, Anchors& anchors) {
  const SectionText text{
      "before and after", "Speed before and after a change",
      no_data("timings before and after a change", "bench --compare OLD.json"),
      "<p>The ratio is the median over all pairs of samples (Hodges-Lehmann), with the interval of the rank "
      "test; p is Mann-Whitney's, two-sided. A difference is called one below 0.01, which chance alone does "
      "in one of a hundred rows.</p>\n"};
  return section(results, results.compare, anchors, text, [&](const std::string& machine, const Rows& rows) {
    return machine_html(rows, machine, anchors);
  });
}

} // namespace hdmbench::report
