#include "harness/report/accuracy_figures.hpp"
#include "harness/report/gnuplot.hpp"
#include "harness/report/plot_style.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench::report {

namespace {

constexpr double plot_width = 460.0;
constexpr double plot_height = 330.0;
constexpr Margins margins{66.0, 24.0, 12.0, 46.0};
constexpr double middle = 150.0; // between the two panels, from the bottom

// A dashed line at the iterations that the scene itself runs on the full image.
std::string own_iterations_mark(const AccuracyRow& row) {
  if (row.levels.empty() || row.levels.back().iterations == 0) {
    return {};
  }
  return fmt::format("set arrow 1 from {0}, graph 0 to {0}, graph 1 nohead dt 2 lc rgb \"#8a8f98\"\n",
                     row.levels.back().iterations);
}

std::string convergence_plot(const AccuracyScene& scene, const AccuracyRow& row, const std::string& prefix) {
  const Convergence& data = *row.convergence;
  const std::vector<double> x(data.iterations_per_level.begin(), data.iterations_per_level.end());
  Interval distances;
  distances.include(0.0);
  distances.include(data.rmsd_to_fem);
  distances.include(data.rmsd_to_fixed_point);
  const bool wide = x.back() > 20.0 * x.front();
  const std::string to_fem = poisson_text(scene.poisson);
  const double axes = plot_height - margins.top - margins.bottom;
  std::string script = plot_start(plot_width, plot_height) + data_block("fem", x, data.rmsd_to_fem) +
                       data_block("point", x, data.rmsd_to_fixed_point) +
                       data_block("energy", x, data.mean_energy) + (wide ? "set logscale x\n" : "") +
                       own_iterations_mark(row) +
                       fmt::format("set xrange [{}:{}]\nset key top right samplen 2 textcolor variable "
                                   "noenhanced\nset multiplot\n",
                                   x.front() == x.back() ? x.front() - 0.5 : x.front(),
                                   x.front() == x.back() ? x.back() + 0.5 : x.back());
  script += plot_margins(plot_width, plot_height, {margins.left, margins.right, margins.top, middle + 8.0});
  script +=
      "set format x ''\n" +
      y_title("RMSD [px]", plot_width, plot_height, middle + 8.0 + (axes - (middle - margins.bottom)) / 2.0) +
      fmt::format(
          "set yrange {}\nplot $fem with linespoints lw 1.8 pt 7 ps 0.35 lc rgb \"#{}\" title {}, $point "
          "with linespoints lw 1.8 pt 7 ps 0.35 lc rgb \"#{}\" title 'to the fixed point'\n",
          distances.range(), plot_colours[1], gnuplot_text("to FEM, " + to_fem), plot_colours[3]);
  Interval energies;
  energies.include(data.mean_energy);
  const bool decades = !energies.empty() && energies.low() > 0.0 && energies.high() > 20.0 * energies.low();
  script += plot_margins(plot_width, plot_height,
                         {margins.left, margins.right, plot_height - middle + 8.0, margins.bottom});
  script += "set format x '%g'\n" +
            y_title("mean energy", plot_width, plot_height, (middle + margins.bottom) / 2.0) +
            x_title("iterations on every level", plot_height) +
            (decades ? fmt::format("set logscale y\nset yrange [{:.6g}:{:.6g}]\n", energies.low() / 1.3,
                                   energies.high() * 1.3)
                     : fmt::format("set yrange {}\n", energies.range())) +
            fmt::format(
                "plot $energy with linespoints lw 1.8 pt 7 ps 0.35 lc rgb \"#{}\" notitle\nunset multiplot\n",
                plot_colours[2]);
  return gnuplot_svg(
      script, prefix,
      fmt::format("RMSD and mean energy over the iterations on every level, scene {}", scene.scene));
}

std::string iterations_plot(const AccuracyScene& scene, const AccuracyRow& row, const std::string& prefix) {
  std::string tics;
  std::string blocks = "$levels << END\n";
  int largest = 1;
  for (std::size_t i = 0; i < row.levels.size(); ++i) {
    const LevelResult& level = row.levels[i];
    blocks += fmt::format("{} {}\n", i, level.iterations);
    tics += fmt::format("{}\"{}\\n{}\" {}", i == 0 ? "" : ", ", level.level, level.extent.width, i);
    largest = std::max(largest, level.iterations);
  }
  const double width = static_cast<double>(row.levels.size());
  std::string script = plot_start(plot_width, plot_height) +
                       plot_margins(plot_width, plot_height, {margins.left, margins.right, 26.0, 68.0}) +
                       blocks + "END\n";
  script += fmt::format("set xrange [-0.7:{}]\nset yrange [0:{}]\nset xtics ({}) scale 0\nset boxwidth 0.72\n"
                        "set style fill solid 1.0 noborder\nset grid noxtics\n",
                        width - 0.3, 1.12 * static_cast<double>(largest), tics);
  script += y_title("iterations", plot_width, plot_height, (plot_height - 26.0 + 68.0) / 2.0) +
            x_title("level and its width, 0 = the full image", plot_height);
  script +=
      fmt::format("plot $levels using 1:2 with boxes lc rgb \"#{}\" notitle, $levels using 1:2:2 with labels "
                  "offset 0,0.6 textcolor rgb \"#{}\" notitle\n",
                  plot_colours[3], text_colour);
  return gnuplot_svg(script, prefix,
                     fmt::format("Iterations on each level of the in-place run, scene {}", scene.scene));
}

std::string figure_html(const std::string& plot, const std::string& caption) {
  return fmt::format("<figure><div class=\"plot\">{}</div><figcaption>{}</figcaption></figure>\n", plot,
                     caption);
}

} // namespace

std::string convergence_figure(const AccuracyScene& scene, Anchors& anchors) {
  const ThesisFigures thesis = thesis_figures(scene.scene);
  std::string html;
  if (const AccuracyRow* const row =
          scene.first([](const AccuracyRow& other) { return other.convergence.has_value(); })) {
    const std::string id = anchors.unique("convergence " + scene.scene);
    html += figure_html(
        convergence_plot(scene, *row, id + '_'),
        fmt::format(
            "{}: each point is a whole run with so many iterations on every level; where the curves run "
            "level, more iterations no longer help. Dashed: what the scene runs.{}",
            escape(method_name(*row)), thesis_reference(thesis.convergence)));
  }
  const AccuracyRow* const sequential = scene.find("sequential");
  if (sequential != nullptr && !sequential->levels.empty()) {
    const std::string id = anchors.unique("iterations " + scene.scene);
    html += figure_html(
        iterations_plot(scene, *sequential, id + '_'),
        fmt::format(
            "{}: iterations on each level until nothing moves or the limit is reached, coarsest first; a "
            "tall bar is a level on which "
            "the field still changes much.{}",
            escape(method_name(*sequential)), thesis_reference(thesis.iterations)));
  }
  return html.empty() ? html : "<div class=\"figures\">\n" + html + "</div>\n";
}

} // namespace hdmbench::report
