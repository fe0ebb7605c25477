#include "harness/report/gnuplot.hpp"
#include "harness/report/plot_style.hpp"
#include "harness/report/speed_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <utility>
#include <vector>

namespace hdmbench::report {

namespace {

constexpr double plot_width = 460.0;
constexpr double plot_height = 430.0;
constexpr Margins margins{66.0, 20.0, 12.0, 48.0};

// Seconds by threads.
using Seconds = std::map<std::int64_t, double>;

struct Scaling {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::map<std::string, Seconds> lines; // by backend and method
};

Scaling largest_scaling(const std::vector<BenchRow>& rows, const std::string& scene) {
  std::map<std::pair<std::int64_t, std::int64_t>, Scaling, std::greater<>> sizes; // the largest first
  for (const BenchRow& row : rows) {
    if (row.scene == scene && row.counts() && row.threads && *row.threads > 0) {
      Scaling& scaling = sizes[{row.width * row.height, row.width}];
      scaling.width = row.width;
      scaling.height = row.height;
      scaling.lines[row.backend + ", " + row.method][*row.threads] = *row.seconds_median;
    }
  }
  for (auto& [pixels, scaling] : sizes) {
    std::erase_if(scaling.lines, [](const auto& line) { return line.second.size() < 2; });
    if (!scaling.lines.empty()) {
      return scaling;
    }
  }
  return {};
}

std::string scaling_plot(const Scaling& scaling, const std::string& prefix, const std::string& label) {
  double most = 1.0;
  double highest = 1.0;
  std::string blocks;
  std::string command = "plot x with lines lw 1.5 dt 2 lc rgb \"#6e6e6e\" title 'ideal'";
  std::size_t index = 0;
  for (const auto& [name, seconds] : scaling.lines) {
    std::vector<double> threads;
    std::vector<double> speed_ups;
    // The fewest threads are taken to scale perfectly; mostly that is one.
    const double one = seconds.begin()->second * static_cast<double>(seconds.begin()->first);
    for (const auto& [count, time] : seconds) {
      threads.push_back(static_cast<double>(count));
      speed_ups.push_back(one / time);
      most = std::max(most, threads.back());
      highest = std::max(highest, speed_ups.back());
    }
    const std::string block = fmt::format("line{}", index);
    blocks += data_block(block, threads, speed_ups);
    command += fmt::format(", ${} with linespoints lw 1.5 pt 7 ps 0.6 lc rgb \"#{}\" title {}", block,
                           plot_colours.at((index + 1) % plot_colours.size()), gnuplot_text(name));
    ++index;
  }
  const std::string tics = most <= 16.0 ? "set xtics 1\n" : "";
  const double axis_middle = margins.bottom + (plot_height - margins.top - margins.bottom) / 2.0;
  return gnuplot_svg(
      plot_start(plot_width, plot_height) + plot_margins(plot_width, plot_height, margins) +
          x_title("threads", plot_height) +
          y_title("times as fast as with one thread", plot_width, plot_height, axis_middle) +
          fmt::format("set xrange [0.8:{0}]\nset yrange [0:{1}]\nset key top left Left reverse "
                      "noenhanced\n{2}",
                      most + 0.2, 1.1 * std::max(most, highest), tics) +
          blocks + command + '\n',
      prefix, label);
}

} // namespace

std::string scaling_figure(const Results& results, const std::string& machine, const std::string& scene,
                           Anchors& anchors) {
  const Scaling scaling = largest_scaling(results.of(results.bench, machine), scene);
  if (scaling.lines.empty()) {
    return {};
  }
  const std::string id = anchors.unique("scaling " + scene);
  const std::string label = fmt::format("Speed-up over threads for the scene {} at {} x {} on {}", scene,
                                        scaling.width, scaling.height, machine);
  return fmt::format(
      "<figure class=\"plot\" id=\"{}\">{}<figcaption>{}, the same work by more threads.</figcaption>"
      "</figure>\n",
      id, scaling_plot(scaling, id + '_', label), size_text(scaling.width, scaling.height));
}

} // namespace hdmbench::report
