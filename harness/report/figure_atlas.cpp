#include "harness/report/figure_atlas.hpp"

#include "harness/report/gnuplot.hpp"
#include "harness/report/plot_style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench::report {

namespace {

constexpr double plot_width = 520.0;
constexpr double plot_height = 330.0;
constexpr Margins margins{66.0, 150.0, 12.0, 46.0}; // the names stand on the right

std::vector<double> knobs_of(const atlas::SeriesResult& series) {
  std::vector<double> values;
  for (const atlas::Point& point : series.points) {
    values.push_back(point.knob);
  }
  return values;
}

std::vector<double> errors_of(const atlas::SeriesResult& series) {
  std::vector<double> values;
  for (const atlas::Point& point : series.points) {
    values.push_back(point.error.value_or(NAN));
  }
  return values;
}

/// An axis is logarithmic where its values span more than a decade and a half; 0 is put in a place of its own
/// below the smallest other value.
struct Axis {
  bool logarithmic = false;
  double zero = 0.0; ///< where 0 is drawn
  double low = 0.0;
  double high = 1.0;

  explicit Axis(const std::vector<double>& values) {
    Interval positive;
    Interval all;
    for (const double value : values) {
      all.include(value);
      if (value > 0.0) {
        positive.include(value);
      }
    }
    logarithmic = !positive.empty() && all.low() >= 0.0 && positive.high() > 30.0 * positive.low();
    if (logarithmic) {
      zero = positive.low() / 4.0;
      low = all.low() > 0.0 ? positive.low() / 1.3 : zero / 1.3;
      high = positive.high() * 1.3;
    } else if (!all.empty()) {
      const double margin = std::max(0.05 * (all.high() - all.low()), 1e-9);
      low = all.low() - margin;
      high = all.high() + margin;
    }
  }
  [[nodiscard]] double place(double value) const { return logarithmic && value == 0.0 ? zero : value; }
};

std::vector<double> placed(std::vector<double> values, const Axis& axis) {
  std::ranges::transform(values, values.begin(), [&](double value) { return axis.place(value); });
  return values;
}

} // namespace

std::string atlas_figure(const AtlasRow& row, const std::string& prefix) {
  std::vector<double> all_knobs;
  std::vector<double> all_errors{row.limit};
  for (const atlas::SeriesResult& series : row.series) {
    std::ranges::copy(knobs_of(series), std::back_inserter(all_knobs));
    std::ranges::copy_if(errors_of(series), std::back_inserter(all_errors),
                         [](double value) { return std::isfinite(value); });
  }
  const Axis x(all_knobs);
  // A run that blew up by many decades would press all others into one line.
  const double most = std::max(1e3 * std::max(row.limit, 1e-3), 1e-9);
  std::ranges::for_each(all_errors, [&](double& value) { value = std::min(value, most); });
  const Axis y(all_errors);
  // Healthy on the left, whichever way the knob is turned.
  const bool falls = !all_knobs.empty() && all_knobs.front() > all_knobs.back();
  std::string script =
      plot_start(plot_width, plot_height) + plot_margins(plot_width, plot_height, margins) +
      x_title(row.knob, plot_height) +
      y_title(row.measure, plot_width, plot_height, margins.bottom + (plot_height - margins.bottom) / 2.0) +
      fmt::format("set xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\n{}{}set key at graph 1.03, graph "
                  "1 left Left reverse samplen 2 "
                  "textcolor variable noenhanced\nset format x '%g'\n",
                  falls ? x.high : x.low, falls ? x.low : x.high, y.low, y.high,
                  x.logarithmic ? "set logscale x\n" : "", y.logarithmic ? "set logscale y\n" : "");
  script +=
      fmt::format("set arrow 1 from graph 0, first {0:.6g} to graph 1, first {0:.6g} nohead dt 2 lc rgb "
                  "\"#8a8f98\"\n",
                  y.place(row.limit));
  if (x.logarithmic && x.low < x.zero) {
    script += fmt::format("set xtics add ('0' {:.6g})\n", x.zero);
  }
  std::string command;
  for (std::size_t i = 0; i < row.series.size(); ++i) {
    const atlas::SeriesResult& series = row.series[i];
    if (series.points.empty()) {
      continue;
    }
    std::vector<double> errors = placed(errors_of(series), y);
    std::ranges::for_each(errors, [&](double& value) { value = value > most ? most : value; });
    script += data_block(fmt::format("s{}", i), placed(knobs_of(series), x), errors);
    command += fmt::format("{}$s{} with linespoints lw 1.8 pt 7 ps 0.4 lc rgb \"#{}\" title {}",
                           command.empty() ? "plot " : ", ", i, plot_colours.at(i % plot_colours.size()),
                           gnuplot_text(series.name));
  }
  return command.empty() ? ""
                         : gnuplot_svg(script + command + '\n', prefix,
                                       fmt::format("{} over {}, a line per method", row.measure, row.knob));
}

} // namespace hdmbench::report
