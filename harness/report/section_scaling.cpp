#include "harness/report/gnuplot.hpp"
#include "harness/report/plot_style.hpp"
#include "harness/report/sections.hpp"

#include "harness/measure/median.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <vector>

namespace hdmbench::report {

namespace {

constexpr double plot_width = 560.0;
constexpr double plot_height = 400.0;
constexpr Margins margins{72.0, 20.0, 12.0, 48.0};

/// The rows of one run.
struct ScalingRun {
  std::vector<hdmbench::ScalingRow> measured;
  std::vector<hdmbench::ScalingRow> modelled; ///< with rising numbers of ranks
};

std::vector<ScalingRun> runs_of(const std::vector<ScalingRow>& rows) {
  std::map<std::tuple<std::string, std::string, std::string, std::string>, ScalingRun> runs;
  for (const ScalingRow& row : rows) {
    ScalingRun& run = runs[{row.energy, row.scaling, row.scene, row.backend}];
    (row.seconds.empty() ? run.modelled : run.measured).push_back(row);
  }
  std::vector<ScalingRun> list;
  for (auto& [key, run] : runs) {
    std::ranges::sort(run.modelled, {}, &hdmbench::ScalingRow::ranks);
    list.push_back(std::move(run));
  }
  return list;
}

std::string measured_table(const std::vector<hdmbench::ScalingRow>& rows) {
  std::string html = table_start("scaling", {">Ranks", "Image", ">Seconds, median", ">Fastest", ">Modelled",
                                             ">The model is off by", ">Messages", ">MB sent"});
  for (const hdmbench::ScalingRow& row : rows) {
    html +=
        fmt::format("<tr><td class=\"number\">{}</td><td>{} × {}</td><td class=\"number\">{:.4f}</td>"
                    "<td class=\"number\">{:.4f}</td><td class=\"number\">{}</td>"
                    "<td class=\"number\">{}</td>"
                    "<td class=\"number\">{}</td><td class=\"number\">{:.2f}</td></tr>\n",
                    row.ranks, row.width, row.height, median(row.seconds), std::ranges::min(row.seconds),
                    row.modelled_seconds ? fmt::format("{:.4f}", *row.modelled_seconds) : "-",
                    model_error_text(row), count_text(row.messages), static_cast<double>(row.bytes) / 1e6);
  }
  return html + std::string(table_end);
}

std::string modelled_plot(const std::vector<hdmbench::ScalingRow>& rows, const std::string& prefix,
                          const std::string& label) {
  std::vector<double> ranks;
  std::vector<double> seconds;
  std::vector<double> ideal;
  for (const hdmbench::ScalingRow& row : rows) {
    ranks.push_back(static_cast<double>(row.ranks));
    seconds.push_back(row.modelled_seconds.value());
    ideal.push_back(rows.front().modelled_seconds.value() * static_cast<double>(rows.front().ranks) /
                    ranks.back());
  }
  const double axis_middle = margins.bottom + (plot_height - margins.top - margins.bottom) / 2.0;
  return gnuplot_svg(
      plot_start(plot_width, plot_height) + plot_margins(plot_width, plot_height, margins) +
          x_title("ranks", plot_height) + y_title("seconds", plot_width, plot_height, axis_middle) +
          fmt::format("set logscale xy 10\nset xrange [{}:{}]\nset format x '10^{{%L}}'\nset format y "
                      "'10^{{%L}}'\nset key bottom left Left reverse noenhanced\n",
                      ranks.front(), ranks.back()) +
          data_block("ideal", ranks, ideal) + data_block("model", ranks, seconds) +
          fmt::format("plot $ideal with lines lw 1.5 dt 2 lc rgb \"#6e6e6e\" title 'as many times faster', "
                      "$model with linespoints lw 1.5 pt 7 ps 0.5 lc rgb \"#{}\" title 'modelled'\n",
                      plot_colours[1]),
      prefix, label);
}

std::string run_html(const ScalingRun& run, Anchors& anchors) {
  std::string html;
  if (!run.measured.empty()) {
    const hdmbench::ScalingRow& first = run.measured.front();
    html += fmt::format("<h3>{} scaling of {}{}, {}</h3>\n", first.scaling == "weak" ? "Weak" : "Strong",
                        escape(first.scene), first.energy == "elastic" ? ", elastic energy" : "",
                        escape(first.backend)) +
            measured_table(run.measured);
  }
  if (run.modelled.size() > 1) {
    const hdmbench::ScalingRow& first = run.modelled.front();
    const WorthRanks worth = worth_ranks(run.modelled);
    const std::string title =
        fmt::format("Modelled, not measured: {} × {}, {} on up to {} ranks", first.width, first.height,
                    first.backend, run.modelled.back().ranks);
    const std::string anchor = anchors.unique("ranks-model");
    html += fmt::format("<figure id=\"{}\">{}<figcaption>{}, each as fast as the ranks of this run and with "
                        "its network. {}</figcaption></figure>\n",
                        anchor, modelled_plot(run.modelled, anchor, title), escape(title),
                        worth.ends ? fmt::format("Beyond {} ranks twice as many save less than a tenth.",
                                                 count_text(worth.ranks))
                                   : "Twice as many ranks save more than a tenth all the way.");
  }
  return html;
}

} // namespace

std::string scaling_section(const Results& results, Anchors& anchors) {
  return section(
      results, results.scaling, anchors,
      {.anchor = "ranks",
       .title = "Several ranks",
       .without_rows = no_data("Seconds on several ranks",
                               "mpirun -n 2 hdmbench bench --scaling strong square --json FILE"),
       .introduction =
           "<p>One image on several processes, with the bits of one. The model takes what "
           "the run measured of a rank and of a message. Seconds are those of a whole solution without "
           "making the scene and without opening sessions, on one rank as on many; of the "
           "elastic energy the cells of all levels are made in them.</p>\n"},
      [&](const std::string& /*machine*/, const std::vector<ScalingRow>& rows) {
        std::string html;
        for (const ScalingRun& run : runs_of(rows)) {
          html += run_html(run, anchors);
        }
        return html;
      });
}

} // namespace hdmbench::report
