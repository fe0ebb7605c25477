#include "harness/report/accuracy_figures.hpp"
#include "harness/report/gnuplot.hpp"
#include "harness/report/plot_style.hpp"
#include "reference/published.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hdmbench::report {

namespace {

constexpr double plot_width = 400.0;
constexpr double plot_height = 330.0;
constexpr Margins margins{58.0, 16.0, 12.0, 46.0};

/// One method with a point per backend.
struct Series {
  std::string name;
  std::string colour;
  const char* shape = "dot"; ///< class of its key: dot, ring or square
  std::vector<double> seconds{};
  std::vector<double> distances{}; ///< RMSD to FEM with Poisson ratio 0, pixels
};

int point_type(const Series& series) {
  const std::string_view shape = series.shape;
  return shape == "dot" ? 7 : shape == "ring" ? 6 : 4;
}

void add_point(Series& series, const std::optional<double>& seconds, const std::optional<double>& distance) {
  if (seconds && distance && *distance > 0.0) { // a logarithm has no place for the truth itself
    series.seconds.push_back(*seconds);
    series.distances.push_back(*distance);
  }
}

std::vector<Series> series_of(const AccuracyScene& scene) {
  std::vector<Series> all;
  for (const std::string& method : accuracy_methods()) {
    if (method == "fem") {
      continue;
    }
    Series series;
    for (const AccuracyRow* const row : scene.rows) {
      if (row->method == method && row->variant.empty() && !row->failed()) {
        series.name = method_name(*row);
        series.colour = method_colour(*row);
        add_point(series, row->seconds_median, row->to_fem_nu0.all);
      }
    }
    all.push_back(std::move(series));
  }
  for (const PublishedAccuracy& row : published_accuracy(scene)) {
    Series series{fmt::format("thesis, {}", row.method), "6e6e6e", row.method == "CPU" ? "ring" : "square"};
    add_point(series, row.seconds, row.rmsd);
    all.push_back(std::move(series));
  }
  std::erase_if(all, [](const Series& series) { return series.seconds.empty(); });
  return all;
}

std::string decades(const Interval& interval, double factor) {
  return fmt::format("[{:.6g}:{:.6g}]", interval.low() / factor, interval.high() * factor);
}

// Over few decades gnuplot alone would write one number or none.
std::string tics_of(const Interval& interval) {
  if (interval.high() > 100.0 * interval.low()) {
    return {};
  }
  std::string tics;
  const int first = static_cast<int>(std::floor(std::log10(interval.low()))) - 1;
  for (int decade = first; decade <= first + 4; ++decade) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      tics += fmt::format("{}{:.6g}", tics.empty() ? "" : ",", factor * std::pow(10.0, decade));
    }
  }
  return "set ytics (" + tics + ")\n";
}

std::string tradeoff_plot(const AccuracyScene& scene, const std::vector<Series>& all,
                          const std::string& prefix) {
  Interval seconds;
  Interval distances;
  std::string blocks;
  std::string command;
  for (std::size_t i = 0; i < all.size(); ++i) {
    seconds.include(all[i].seconds);
    distances.include(all[i].distances);
    blocks += data_block(fmt::format("points{}", i), all[i].seconds, all[i].distances);
    command += fmt::format("{}$points{} with points pt {} ps 0.8 lw 1.8 lc rgb \"#{}\" notitle",
                           i == 0 ? "plot " : ", ", i, point_type(all[i]), all[i].colour);
  }
  std::string script = plot_start(plot_width, plot_height) + plot_margins(plot_width, plot_height, margins);
  const AccuracyRow* const fem = scene.find_fem(0.0);
  if (fem != nullptr && fem->seconds_median) {
    seconds.include(*fem->seconds_median);
    script += fmt::format("set arrow 1 from {0}, graph 0 to {0}, graph 1 nohead dt 2 lc rgb \"#8a8f98\"\n"
                          "set label 3 'FEM' at {0}, graph 0.95 right offset -0.5,0 textcolor rgb \"#{1}\"\n",
                          *fem->seconds_median, text_colour);
  }
  script += y_title("RMSD to FEM, ν = 0 [px]", plot_width, plot_height,
                    (plot_height - margins.top + margins.bottom) / 2.0) +
            x_title("seconds", plot_height) +
            fmt::format("set logscale xy\nset xrange {}\nset yrange {}\n{}", decades(seconds, 1.6),
                        decades(distances, 1.4), tics_of(distances));
  return gnuplot_svg(
      script + blocks + command + '\n', prefix,
      fmt::format("RMSD to FEM over seconds, both logarithmic, scene {}; the figures stand in the table "
                  "beside it",
                  scene.scene));
}

} // namespace

std::string tradeoff_figure(const AccuracyScene& scene, Anchors& anchors) {
  const std::vector<Series> all = series_of(scene);
  if (all.empty()) {
    return {};
  }
  std::string legend = "<p class=\"legend\">";
  for (const Series& series : all) {
    legend += fmt::format("<span class=\"key\"><i class=\"point {}\" style=\"color:#{}\"></i>{}</span>",
                          series.shape, series.colour, escape(series.name));
  }
  return fmt::format(
      "<figure class=\"beside\"><div class=\"plot\">{}</div>{}</p><figcaption>Error for its time, both "
      "logarithmic: lower left is better. A point per backend; dashed is the time of "
      "FEM itself.{}</figcaption></figure>\n",
      tradeoff_plot(scene, all, anchors.unique("tradeoff " + scene.scene) + '_'), legend,
      published_accuracy(scene).empty() ? "" : " The thesis's times are of 2008.");
}

} // namespace hdmbench::report
